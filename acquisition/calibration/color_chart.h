// Finds a chart of 24 patches (4 rows of 6, as the ColorChecker Classic) in a picture by OpenCV's mcc.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "core/fiducials/color_chart_patches.h"
#include "core/image/image.h"

namespace ulf::acquisition {

struct ChartPatch {
  Eigen::Vector3d rgb = Eigen::Vector3d::Zero();  // linear light above black, medians over the patch's middle
  double unevenness = 0;  // median deviation of green from its median, as a share of the median
  bool clipped = false;   // whether any pixel of the middle is
  bool usable() const { return !clipped && unevenness <= kMostUneven && rgb.minCoeff() > 0; }
  static constexpr double kMostUneven = 0.08;  // a reflection, a shadow's edge, or another thing. Guessed.
};

struct MeasuredChart {
  std::array<ChartPatch, kChartPatches> patches = {};
  std::array<Eigen::Vector2d, 4> corners = {};  // of the outline, pixels, clockwise from the first patch
};

// `black_level`: share of full scale; `clipped`: of ClippedPixels(), or empty. Returns none if there is no
// chart, or if what looks like one is under some 100 pixels wide or has greys that are not in order.
std::optional<MeasuredChart> FindColorChart(const Image& image, double black_level, const cv::Mat& clipped);

}  // namespace ulf::acquisition
