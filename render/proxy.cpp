#include "render/proxy.h"

#include <algorithm>

namespace ulf {

using Eigen::Vector3d;

double PlaneInCamera::DepthOf(const Vector3d& ray_with_unit_z) const {
  const double slope = normal.dot(ray_with_unit_z);
  if (slope * far_depth <= offset) return far_depth;  // parallel to the plane or away from it
  return offset / slope;
}

std::optional<PlaneInCamera> Proxy::AsPlane(const Rigid3& /*cam_from_world*/) const { return std::nullopt; }

std::optional<PlaneInCamera> PlaneProxy::AsPlane(const Rigid3& cam_from_world) const {
  constexpr double kFarOverDistance = 1000;
  const Vector3d center_in_cam = cam_from_world * subject_.center_in_world;
  const double distance = center_in_cam.norm();
  PlaneInCamera plane;
  if (distance > 1e-9 * std::max(1.0, subject_.radius)) {
    plane.normal = center_in_cam / distance;
    plane.offset = distance;
  } else {
    plane.offset = std::max(subject_.radius, 1e-6);  // inside the very centre: the sphere's far side
  }
  plane.far_depth = kFarOverDistance * plane.offset;
  return plane;
}

cv::Mat PlaneProxy::Depth(const CameraModel& camera, const Rigid3& cam_from_world) const {
  const PlaneInCamera plane = *AsPlane(cam_from_world);
  cv::Mat depth(camera.height, camera.width, CV_32F);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      depth.at<float>(y, x) = static_cast<float>(
          plane.DepthOf({(x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1.0}));
  return depth;
}

}  // namespace ulf
