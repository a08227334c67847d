// Masks that leave a disc of the plane z = 0, where the simulated scenes' wall is.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"

namespace ulf::test {

// By how much the point of the plane that a pixel shows lies inside the disc; negative: outside.
inline double InsideDisc(double radius, const CameraModel& camera, const Rigid3& cam_from_world, int x,
                         int y) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const Eigen::Vector3d ray = world_from_cam.rotation * *camera.RayFromImg({x + 0.5, y + 0.5});
  const Eigen::Vector3d point = world_from_cam.translation - ray * (world_from_cam.translation.z() / ray.z());
  return radius - point.head<2>().norm();
}

// The scene's views with their masks in place of their photographs.
inline std::shared_ptr<RenderScene> DiscMasks(const SceneSpec& spec, double radius) {
  const auto masks = MakeScene(spec);
  for (SceneView& view : masks->views) {
    cv::Mat mask(view.camera.height, view.camera.width, CV_8UC3, cv::Scalar::all(0));
    for (int y = 0; y < mask.rows; ++y)
      for (int x = 0; x < mask.cols; ++x)
        if (InsideDisc(radius, view.camera, view.cam_from_world, x, y) > 0)
          mask.at<cv::Vec3b>(y, x) = cv::Vec3b::all(255);
    view.photograph = HoldPhotograph(MakePyramid(mask));
  }
  return masks;
}

}  // namespace ulf::test
