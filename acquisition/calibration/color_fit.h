// A colour profile from a chart of 24 patches, or a white balance from a grey card.
//
// White balance is the median over the usable greys of what their published colours ask for. The matrix then
// minimises differences in L* a* b* (those of colour divided as CIEDE2000 does, by 1 + 0.045 chroma), with
// Huber's weights, over all usable patches; its rows sum to one. A column of the chart is left out in turn,
// everything is found again without it, and its patches are judged: what the profile is worth on colours that
// took no part.
#pragma once

#include <string>
#include <vector>

#include "acquisition/calibration/color_chart.h"
#include "core/image/color_profile.h"

namespace ulf::acquisition {

// Of a patch that took part, CIEDE2000 from its published colour, at the exposure that fits best.
struct PatchDifference {
  int patch = 0;           // index
  double as_recorded = 0;  // the camera's numbers taken for linear sRGB
  double balanced = 0;     // by white balance alone
  double profiled = 0;     // by the profile
  double held_out = 0;     // by the profile that was found without this patch's column
};

struct ColorFit {
  std::string refusal = {};  // why there is no profile; empty when there is one
  ColorProfile profile = {};
  std::vector<PatchDifference> patches = {};
  std::vector<int> clipped = {}, uneven = {};  // indices of patches that took no part
  bool ok() const { return refusal.empty(); }
  // Mean and largest over the patches.
  double Mean(double PatchDifference::*which) const;
  double Most(double PatchDifference::*which) const;
};

// `charts`: of several pictures of one chart in one light; their medians are taken.
ColorFit FitColorProfile(const std::vector<MeasuredChart>& charts);

struct GreyCard {
  std::string refusal = {};
  std::array<double, 3> white_balance{1, 1, 1};
  double light = 0;       // green, of full scale
  double unevenness = 0;  // of the ratios of colours over the card, as a share
  bool ok() const { return refusal.empty(); }
};
// The card fills the middle third of the picture, across and down.
GreyCard BalanceOfGreyCard(const Image& image, double black_level, const cv::Mat& clipped);

}  // namespace ulf::acquisition
