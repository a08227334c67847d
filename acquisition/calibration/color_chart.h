// A chart of 24 patches (4 rows of 6, as the ColorChecker Classic) in a picture, found by OpenCV's module mcc.
//
// Patches count from the chart's dark brown, row by row, as its maker counts them; the last row goes from white to black.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "core/image/image.h"

namespace ulf::acquisition {

inline constexpr int kChartColumns = 6, kChartRows = 4, kChartPatches = 24;
inline constexpr int kFirstGrey = 18;  // index of the white patch; the greys follow

// L* a* b* (D50) that the maker published for charts made before November 2014 (later ones differ by less than 3
// units).
const std::array<Eigen::Vector3d, kChartPatches>& ChartLab();

// Where patches are on the chart: its outline is a rectangle of this size, in the units of OpenCV's model, with patches 2.5
// wide that are 0.25 apart.
inline constexpr double kChartWidth = 16.75, kChartHeight = 11.25, kPatchWidth = 2.5, kPatchGap = 0.25;
Eigen::Vector2d PatchCenter(int patch);

struct ChartPatch {
  Eigen::Vector3d rgb = Eigen::Vector3d::Zero();  // linear light above black, medians over the patch's middle
  double unevenness = 0;  // median deviation of green from its median, as a share of it
  bool clipped = false;   // any pixel of the middle
  bool usable() const { return !clipped && unevenness <= kMostUneven && rgb.minCoeff() > 0; }
  static constexpr double kMostUneven = 0.08;  // a reflection, a shadow's edge, or another thing. Guessed.
};

struct MeasuredChart {
  std::array<ChartPatch, kChartPatches> patches = {};
  std::array<Eigen::Vector2d, 4> corners =
      {};  // of the outline, from the first patch clockwise; image pixels
};

// `clipped`: of ClippedPixels(), or empty. None where there is no chart, where it is smaller than some 100 pixels across,
// or where its greys are not in order: then something else was taken for one.
std::optional<MeasuredChart> FindColorChart(const Image& image, double black_level, const cv::Mat& clipped);

}  // namespace ulf::acquisition
