#include "coverage/bound/sphere_outline.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "coverage/bound/capture_presets.h"

namespace ulf::coverage {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::optional<std::vector<Vector2d>> SphereOutline(const CameraModel& camera, const Rigid3& cam_from_world,
                                                   const Subject& subject, int corners) {
  const Vector3d center_in_cam = cam_from_world * subject.center_in_world;
  const double distance = center_in_cam.norm();
  if (distance <= subject.radius) return std::nullopt;
  const double ratio = subject.radius / distance;
  const Vector3d axis = center_in_cam / distance, x = axis.unitOrthogonal(), y = axis.cross(x);
  const Vector3d middle = center_in_cam * (1 - ratio * ratio);
  const double radius = subject.radius * std::sqrt(1 - ratio * ratio);
  std::vector<Vector2d> outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * M_PI * i / corners;
    const auto img = camera.ImgFromCam(middle + radius * (std::cos(angle) * x + std::sin(angle) * y));
    if (!img) return std::nullopt;
    outline.push_back(*img);
  }
  return outline;
}

SafetyRectangle SafetyRectangle::Of(const CameraModel& camera) {
  const Vector2d size(camera.width, camera.height);
  return {0.5 * (1 - kRectangleShare) * size, 0.5 * (1 + kRectangleShare) * size};
}

bool SafetyRectangle::Holds(const std::vector<Vector2d>& outline) const {
  return std::ranges::all_of(outline, [this](const Vector2d& img) {
    return (img.array() >= low.array()).all() && (img.array() <= high.array()).all();
  });
}

Subject SubjectOnAxis(const CameraModel& camera, const Rigid3& cam_from_world, double depth,
                      double width_share) {
  const double half_angle = std::atan(0.5 * width_share * camera.width / camera.fx);
  return {cam_from_world.Inverse() * Vector3d(0, 0, depth), depth * std::sin(half_angle)};
}

}  // namespace ulf::coverage
