#include "render/fields/aperture.h"

#include <algorithm>

#include "core/geometry/pinhole.h"

namespace ulf::render {

using Eigen::Vector2d;
using Eigen::Vector3d;

double FocusDepth(const Aperture& aperture, const Rigid3& cam_from_world) {
  const Vector3d focus_in_cam = cam_from_world * aperture.focus_in_world;
  constexpr double kLeastShare = 1e-3;  // of the distance to the focus point
  constexpr double kLeastDepth = 1e-9;  // for a camera at that point
  return std::max({focus_in_cam.z(), kLeastShare * focus_in_cam.norm(), kLeastDepth});
}

double ApertureRadius(double f_number, double focal_px, int width_px, double sensor_width_mm) {
  return FNumber(f_number, focal_px, width_px, sensor_width_mm);
}

// f = 2 N R: the same formula gives the radius R and the f-number N.
double FNumber(double radius_m, double focal_px, int width_px, double sensor_width_mm) {
  const double focal_m = 1e-3 * sensor_width_mm * focal_px / width_px;
  return 0.5 * focal_m / radius_m;
}

PlaneInCamera FocalPlane::Background(const Rigid3& cam_from_world) const {
  PlaneInCamera plane;
  plane.offset = FocusDepth(aperture_, cam_from_world);
  constexpr double kFarOverDepth = 10;  // every ray of a picture meets the plane within it
  plane.far_depth = kFarOverDepth * plane.offset;
  return plane;
}

std::shared_ptr<const RenderScene> WithFocalPlane(const RenderScene& scene, const Aperture& aperture) {
  return WithProxy(scene, std::make_shared<FocalPlane>(aperture));
}

Vector3d PointOnProxy(const Proxy& proxy, const CameraModel& camera, const Rigid3& cam_from_world,
                      const Vector2d& img) {
  CameraModel pixel = camera;
  pixel.width = pixel.height = 1;
  pixel.cx += 0.5 - img.x();
  pixel.cy += 0.5 - img.y();
  const double depth = proxy.Depth(pixel, cam_from_world).at<float>(0, 0);
  return cam_from_world.Inverse() * (depth * PinholeRay(camera, img));
}

}  // namespace ulf::render
