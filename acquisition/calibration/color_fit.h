// Fits a colour profile to a chart of 24 patches, or a white balance to a grey card.
//
// White balance is the median, over the usable grey patches, of the factors that map them to their published
// colours. The 3 x 3 matrix then minimises differences in CIE L*a*b* (those in a* and b* divided by 1 + 0.045
// chroma, as CIEDE2000 does), with Huber weights, over all usable patches; its rows sum to one. For
// cross-validation the profile is fitted without each column of the chart in turn and tested on it.
#pragma once

#include <string>
#include <vector>

#include "acquisition/calibration/color_chart.h"
#include "core/image/color_profile.h"

namespace ulf::acquisition {

// The differences (CIEDE2000) of a used patch from its published colour, at the exposure that fits best.
struct PatchDifference {
  int patch = 0;           // index
  double as_recorded = 0;  // with the camera's values taken as linear sRGB
  double balanced = 0;     // with white balance alone
  double profiled = 0;     // with the profile
  double held_out = 0;     // with the profile that was fitted without this patch's column
};

struct ColorFit {
  std::string refusal = {};  // why there is no profile; empty when there is one
  ColorProfile profile = {};
  std::vector<PatchDifference> patches = {};
  std::vector<int> clipped = {}, uneven = {};  // indices of patches that took no part
  bool ok() const { return refusal.empty(); }
  // Return the mean and the largest difference over the patches.
  double Mean(double PatchDifference::*which) const;
  double Most(double PatchDifference::*which) const;
};

// Fits a profile to the medians of `charts`, from one or more pictures of one chart in one light.
ColorFit FitColorProfile(const std::vector<MeasuredChart>& charts);

struct GreyCard {
  std::string refusal = {};  // why there is no white balance; empty when there is one
  std::array<double, 3> white_balance{1, 1, 1};
  double light = 0;       // green channel, share of full scale
  double unevenness = 0;  // spread of red/green and blue/green over the card, as a share
  bool ok() const { return refusal.empty(); }
};
// Measures white balance (factors of R, G, B, green 1) on a card that fills the middle third of the picture,
// across and down. `black_level`: share of full scale; `clipped`: of ClippedPixels(), or empty.
GreyCard BalanceOfGreyCard(const Image& image, double black_level, const cv::Mat& clipped);

}  // namespace ulf::acquisition
