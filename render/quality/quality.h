// Measures the difference of a rendering from the photograph, both in 8-bit sRGB.
#pragma once

#include <opencv2/core.hpp>

namespace ulf::render {

struct Quality {
  double psnr_db = 0;  // over all three channels; at most 100, which identical images have
  double ssim = 0;     // Wang et al. 2004, window 11x11, Gaussian sigma 1.5, mean of the channels
  long pixels = 0;     // number of compared pixels
};

// `mask` is CV_8U, nonzero where to compare; without such pixels the result is 0. SSIM leaves out the five
// pixels at the image's edge, where the window does not fit.
Quality CompareImages(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& mask);

// These compute SSIM as other programs do (render/quality/protocol.h).
double SsimUniform(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& mask);
double SsimPadded(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& mask);

}  // namespace ulf::render
