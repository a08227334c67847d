// A photograph as stereo wants it: grey, without distortion, at the working size.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct StereoView {
  CameraModel camera;  // without distortion
  Rigid3 cam_from_world;
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  cv::Mat grey;   // CV_32F, display-encoded, 0 to 255
  cv::Mat valid;  // CV_8U, 0 where a mask hides the photograph; empty: none does

  // None behind the camera or outside the picture.
  std::optional<Eigen::Vector2d> See(const Eigen::Vector3d& point_in_world) const;
  // Through a pixel's centre, of depth 1, in the world frame.
  Eigen::Vector3d RayInWorld(int x, int y) const;
};

// The longer side has `size_px` pixels, or what the photograph has where that is less.
StereoView MakeStereoView(const SceneView& view, int size_px);

}  // namespace ulf::render
