// Evaluates as papers on view synthesis do: some photographs are left out, neither geometry, points nor
// choices depend on them, and the whole frame counts.
#pragma once

#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf::render {

struct ProtocolSplit {
  std::string name;              // the name that was asked for
  std::vector<int> test, given;  // indices of views; others are not used
};

// The values of `protocol` are:
//   llff             every 8th photograph by name, from the first on, is left out (Mildenhall et al. 2019)
//   every:N          the same with every N-th
//   nerf-synthetic   images/test is left out, images/train is given (Mildenhall et al. 2020)
//   a file           its lines name the photographs that are left out, with or without folder and ending
// Throws Refusal for another text and for a split that leaves nothing out or gives fewer than two.
ProtocolSplit SplitByProtocol(const LightField& light_field, const std::string& protocol);

// Returns the light field that these views alone (indices, ascending) would give: points are fitted again to
// their observations, and points with fewer than two, or without tracks, are left out. The subject of an
// imported set is found anew if the optical axes or the points determine it.
LightField SubsetOfViews(const LightField& light_field, const std::vector<int>& views);

// The measures of papers over the whole frame, except pixels without light in the photograph (masked, or
// beyond the edge after undistortion). Pictures are 8-bit sRGB, `valid` is CV_8U.
struct PaperQuality {
  double psnr_db = 0;       // 10 log10(1 / mean square) of all channels
  double ssim = 0;          // Gaussian window of 11 px, inner pixels: TensorFlow's, NeRF's tables
  double ssim_uniform = 0;  // uniform window of 7 px, sample covariance, inner pixels: scikit-image's default
  double ssim_padded =
      0;  // Gaussian window of 11 px, zeros beyond the edge, all pixels: 3D Gaussian splatting's
};
PaperQuality CompareAsPapers(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& valid);

}  // namespace ulf::render
