// Photographs of plane patches, drawn by casting a ray through every pixel, with the depth that is right.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "render/stereo/stereo_view.h"
#include "tests/support/floors.h"

namespace ulf::test {

// A parallelogram in the world; `grey` of the coordinates along its sides, each 0 to 1.
struct Patch {
  Eigen::Vector3d corner, side, other_side;
  std::function<float(double, double)> grey;
};

// Waves that differ in every direction and scale down to `finest` of a side.
std::function<float(double, double)> Mottled(double finest, unsigned seed);
std::function<float(double, double)> Plain(float grey);

struct Drawn {
  StereoView view;
  cv::Mat depth;  // CV_32F, along the optical axis; 0: none
};

// Four rays a pixel; `gain` and `offset` are the exposure's.
Drawn Draw(const std::vector<Patch>& patches, const Eigen::Vector3d& center, const Eigen::Vector3d& target,
           int width = 120, int height = 90, double focal_px = 110, float gain = 1, float offset = 0);

}  // namespace ulf::test
