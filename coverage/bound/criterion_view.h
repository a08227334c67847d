// A camera of the coverage image with its pose, as the coverage bound (criterion.h) compares them.
#pragma once

#include <Eigen/Core>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf::coverage {

// World coordinates, any unit; pixels of the coverage image, without distortion.
struct CriterionView {
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cam_from_world = Eigen::Matrix3d::Identity();  // rotation
  double fx = 0, fy = 0, cx = 0, cy = 0;                         // focal lengths and principal point
  double width = 0, height = 0;                                  // of the coverage image

  // Makes a view of `camera` without its distortion, resized to `coverage_width_px`.
  static CriterionView From(const CameraModel& camera, const Rigid3& cam_from_world, int coverage_width_px);
  // Returns a camera at `center_in_world` that aims at `target_in_world`, with this view's intrinsics.
  CriterionView AimedAt(const Eigen::Vector3d& target_in_world, const Eigen::Vector3d& center_in_world,
                        const Eigen::Vector3d& up_in_world) const;
};

}  // namespace ulf::coverage
