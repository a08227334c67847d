// Interpolates a camera path through keyframes.
//
// Positions follow a natural cubic spline over time, which is twice continuously differentiable. If every
// keyframe has a target, the targets follow such a spline as well, and the camera always looks at the target.
// Otherwise rotations follow a cubic spline through their quaternions, normalised; of q and -q the one nearer
// to the previous keyframe is used. Focal lengths and focus depths are interpolated in their logarithm, so
// that a zoom has an even speed on the screen.
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
  // The camera looks at this point, with `up_in_world` upwards; none: it has the rotation `world_from_cam`.
  std::optional<Eigen::Vector3d> target_in_world = {};
  Eigen::Vector3d up_in_world = -Eigen::Vector3d::UnitY();
  Eigen::Quaterniond world_from_cam = Eigen::Quaterniond::Identity();
  double focal_px = 1;
  double aperture_radius = 0;  // world units
  double focus_depth = 1;      // of the focal plane along the optical axis, world units; positive
};

struct KeyframedPose {
  Rigid3 cam_from_world;
  double focal_px = 1;
  double aperture_radius = 0;
  double focus_depth = 1;
};

// Returns poses at evenly spaced times from the first keyframe to the last; if `frames` is 1, the first
// keyframe. There must be a keyframe, and times must grow from one to the next. Throws Error that names the
// two keyframes between which the path is not determined.
std::vector<KeyframedPose> InterpolateKeyframes(const std::vector<PathKeyframe>& keyframes, int frames);

// A natural cubic spline (second derivative 0 at both ends); row i of `values` is for times[i], which grow.
class CubicSpline {
 public:
  CubicSpline(std::vector<double> times, Eigen::MatrixXd values);
  Eigen::VectorXd At(double time) const;

 private:
  std::vector<double> times_;
  Eigen::MatrixXd values_, second_;  // second derivatives
};

}  // namespace ulf::render
