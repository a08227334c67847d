// How much a rendering differs from the photograph, both in 8-bit sRGB.
#pragma once

#include <opencv2/core.hpp>

namespace ulf::render {

struct Quality {
  double psnr_db = 0;  // over all three channels; 100 for identical images
  double ssim = 0;  // Wang et al. 2004: Gaussian window of 11x11 pixels with sigma 1.5, mean of the channels
  long pixels = 0;  // that were compared
};

// `mask`: CV_8U, nonzero where to compare; without such pixels the result is 0. SSIM leaves out the five
// pixels at the image's edge, where the window does not fit.
Quality CompareImages(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& mask);

// SSIM as others compute it (render/quality/protocol.h says who).
double SsimUniform(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& mask);
double SsimPadded(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& mask);

}  // namespace ulf::render
