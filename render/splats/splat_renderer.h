// Draws Gaussians on the processor as the rasteriser of Kerbl et al. 2023 does: each is projected to an
// ellipse (Zwicker et al. 2001, "EWA splatting"), a low-pass of 0.3 px squared is added, and the ellipses are
// blended from near to far by the depth of their centres. Viewers of others do the same, so that a fit of
// colours to these pictures holds there.
//
// One thread draws a picture, whatever the machine: the same input gives the same numbers.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/splats/gaussians.h"

namespace ulf::render {

struct SplatPicture {
  cv::Mat srgb;     // CV_32FC3, B G R, display-encoded, over black
  cv::Mat opacity;  // CV_32F, 0 to 1
};

// `camera` must be without distortion.
SplatPicture DrawSplats(const Gaussians& gaussians, const CameraModel& camera, const Rigid3& cam_from_world);

// What one Gaussian gave to a picture: the sums over its pixels of its weight there, and of the weight times
// the difference of a photograph from the picture.
struct SplatShare {
  std::uint32_t gaussian = 0;
  float weight = 0;
  Eigen::Vector3f difference = Eigen::Vector3f::Zero();  // R G B, display-encoded
  // If shapes are asked for, these belong to its opacity and to the logarithm of its size: the sums over its
  // pixels of the picture's derivative times the difference, and of the derivative's size times that of all
  // Gaussians of the pixel together. Their ratio is a step that does not overshoot when all take theirs.
  Eigen::Vector2f shape_slope = Eigen::Vector2f::Zero(), shape_curvature = Eigen::Vector2f::Zero();
};

struct SplatComparison {
  std::vector<SplatShare> shares;  // of the Gaussians that are seen, in the order of their numbers
  double squared_error = 0;        // sum over pixels and channels
  long pixels = 0;                 // that were compared
};

// Draws the picture and compares it with `photograph`: CV_8UC3, or CV_8UC4 with 0 where there is nothing to
// compare, of the camera's size.
SplatComparison CompareSplats(const Gaussians& gaussians, const CameraModel& camera,
                              const Rigid3& cam_from_world, const cv::Mat& photograph, bool with_shapes);

}  // namespace ulf::render
