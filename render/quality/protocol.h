// The protocols by which papers on view synthesis measure: some photographs are left out, nothing is made
// from them (geometry, points, no choice), and the whole frame counts.
#pragma once

#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf::render {

struct ProtocolSplit {
  std::string name;              // as it was asked for
  std::vector<int> test, given;  // indices of views; what is in neither is not used
};

// `protocol`:
//   llff every 8th photograph by name, from the first on, is left out (Mildenhall et al. 2019, 2020) every:N
//   the same with every N-th nerf-synthetic photographs of images/test are left out, those of images/train
//   are given (Mildenhall et al. 2020) a file its lines name the photographs that are left out, with or
//   without folder and ending
// Throws Refusal for another text and for a split that leaves nothing out, or fewer than two.
ProtocolSplit SplitByProtocol(const LightField& light_field, const std::string& protocol);

// The light field as these views alone (indices, ascending) make it: points are fitted again to what they see
// of them, and those that fewer than two of them see are left out, as are points without tracks. Of an
// imported set the subject is found anew where the optical axes or the points tell it.
LightField OnlyViews(const LightField& light_field, const std::vector<int>& views);

// As papers define it, over the whole frame; of photographs that have no light in some pixels (masked, or
// beyond the edge after undistortion) over all others. Pictures in 8-bit sRGB, `valid` CV_8U.
struct PaperQuality {
  double psnr_db = 0;       // 10 log10(1 / mean square) of all channels
  double ssim = 0;          // Gaussian window of 11 px, inner pixels: TensorFlow's, NeRF's tables
  double ssim_uniform = 0;  // uniform window of 7 px, sample covariance, inner pixels: scikit-image's default
  double ssim_padded =
      0;  // Gaussian window of 11 px, zeros beyond the edge, all pixels: 3D Gaussian splatting's
};
PaperQuality CompareAsPapers(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& valid);

}  // namespace ulf::render
