// How near a rendering comes to the photograph, both 8-bit sRGB.
#pragma once

#include <opencv2/core.hpp>

namespace ulf::render {

struct Quality {
  double psnr_db = 0;  // over all three channels; 100 where nothing differs
  double ssim = 0;     // Wang et al. 2004, Gaussian window 11x11 of sigma 1.5, mean of the channels
  long pixels = 0;     // compared
};

// `mask`: CV_8U, nonzero where to compare. SSIM leaves out the five pixels at the image's edge, where the
// window does not fit; zero pixels to compare give zeroes.
Quality CompareImages(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& mask);

}  // namespace ulf::render
