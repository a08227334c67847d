// The corners of a square marker to a twentieth of a pixel, from its sides: along the part of a side that is
// next to the corner the step from dark to bright is found across it at every pixel, a line laid through, and
// the lines of two sides meet in the corner. A small marker has room for that where the usual window about
// the corner would hold its cells or its neighbour; and lines of 24 pixels are straight in any lens.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>

namespace ulf {

using MarkerImage = std::array<Eigen::Vector2d, 4>;  // corners in the image, clockwise from the upper left

// `gray`: CV_8UC1, display-encoded. `corners`: good to a pixel or two, pixel centres at integer + 0.5, and so
// is the result. `cells`: of the marker's side, its border counted. A corner whose sides are not to be seen
// stays where it was.
MarkerImage RefinedBySides(const cv::Mat& gray, const MarkerImage& corners, int cells);

}  // namespace ulf
