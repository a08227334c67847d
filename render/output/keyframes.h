// A camera's way through keyframes.
//
// Positions follow a natural cubic spline over time, which is twice continuously differentiable; so do the
// targets where every keyframe names one, and then the camera looks at the target all along. Else rotations
// follow a cubic spline through their quaternions, of q and -q always the one nearer to the keyframe before,
// made unit again: as smooth as the spline. Focal lengths and distances of focus are interpolated in their
// logarithm, so that a zoom goes at an even speed on the screen.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/geometry/rigid3.h"

namespace ulf::render {

struct PathKeyframe {
  double time_s = 0;
  Eigen::Vector3d eye_in_world = Eigen::Vector3d::Zero();
  // One of the two: what the camera looks at with `up_in_world` upwards, or its turn.
  std::optional<Eigen::Vector3d> target_in_world = {};
  Eigen::Vector3d up_in_world = -Eigen::Vector3d::UnitY();
  Eigen::Quaterniond world_from_cam = Eigen::Quaterniond::Identity();
  double focal_px = 1;
  double aperture_radius = 0;  // world units
  double focus_depth = 1;      // of its focal plane, along the optical axis
};

struct KeyframedPose {
  Rigid3 cam_from_world;
  double focal_px = 1;
  double aperture_radius = 0;
  double focus_depth = 1;
};

// At evenly spaced times from the first keyframe to the last; times must grow from keyframe to keyframe. One
// frame: the first. Throws Error that names the keyframe where the way between two is not determined.
std::vector<KeyframedPose> InterpolateKeyframes(const std::vector<PathKeyframe>& keyframes, int frames);

// Natural: no bend at both ends. Rows of `values` belong to `times`, which grow.
class CubicSpline {
 public:
  CubicSpline(std::vector<double> times, Eigen::MatrixXd values);
  Eigen::VectorXd At(double time) const;

 private:
  std::vector<double> times_;
  Eigen::MatrixXd values_, second_;  // derivatives
};

}  // namespace ulf::render
