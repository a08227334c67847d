// A virtual lens with a wide aperture (thesis, section 5.5). Rays enter through a disc around the virtual
// camera's centre, perpendicular to its optical axis. Points on the focal plane, which is perpendicular to
// the axis as well, are sharp. Recorded views are samples of the disc; aperture_field.h weights them.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "render/scene/scene.h"

namespace ulf::render {

struct Aperture {
  // The disc's radius in world units. A radius below the distance between neighbouring viewpoints, or 0,
  // gives the smallest aperture that they allow, which is the blending field without an aperture.
  double radius = 0;
  Eigen::Vector3d focus_in_world = Eigen::Vector3d::Zero();  // a point of the focal plane
  bool operator==(const Aperture&) const = default;
};

// Returns the depth of the focal plane along the optical axis, world units. It is always positive: if the
// focus point is not in front of the camera, the plane lies close in front of it.
double FocusDepth(const Aperture& aperture, const Rigid3& cam_from_world);

// Returns the radius in metres of an f-number's aperture, for a camera of focal length `focal_px` whose
// picture of `width_px` pixels covers a sensor of `sensor_width_mm`.
double ApertureRadius(double f_number, double focal_px, int width_px, double sensor_width_mm);
// Does the reverse.
double FNumber(double radius_m, double focal_px, int width_px, double sensor_width_mm);

// The focal plane as a proxy, which hides nothing. With an aperture it replaces the scene's proxy, whose
// geometry would bring every point into focus.
class FocalPlane : public Proxy {
 public:
  explicit FocalPlane(const Aperture& aperture) : aperture_(aperture) {}
  std::string Name() const override { return "focal plane"; }
  PlaneInCamera Background(const Rigid3& cam_from_world) const override;

 private:
  Aperture aperture_;
};

std::shared_ptr<const RenderScene> WithFocalPlane(const RenderScene& scene, const Aperture& aperture);

// Returns the point of the proxy, world frame, that an undistorted camera sees at `img` (px).
Eigen::Vector3d PointOnProxy(const Proxy& proxy, const CameraModel& camera, const Rigid3& cam_from_world,
                             const Eigen::Vector2d& img);

}  // namespace ulf::render
