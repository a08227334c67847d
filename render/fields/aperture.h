// A virtual lens that is wide open (thesis, section 5.5): rays enter through a disc about the virtual
// camera's centre, perpendicular to its optical axis, and what lies on the focal plane, perpendicular to it
// as well, is sharp. Recorded views are the points of the disc through which there are rays; aperture_field.h
// has their weights.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "render/scene/scene.h"

namespace ulf::render {

struct Aperture {
  // Of the disc, in world units. 0, or less than the viewpoints are apart: the smallest aperture that they
  // allow, which is the blending field as it is without one.
  double radius = 0;
  Eigen::Vector3d focus_in_world = Eigen::Vector3d::Zero();  // the focal plane goes through it
  bool operator==(const Aperture&) const = default;
};

// Of the focal plane along the optical axis; positive: a camera that has the point beside it or behind it
// focuses close by.
double FocusDepth(const Aperture& aperture, const Rigid3& cam_from_world);

// In metres, for a picture of `width_px` that covers a sensor of that width.
double ApertureRadius(double f_number, double focal_px, int width_px, double sensor_width_mm);
// The other way round.
double FNumber(double radius_m, double focal_px, int width_px, double sensor_width_mm);

// Geometry would bring everything into focus: with an aperture the focal plane is the proxy, and it hides
// nothing.
class FocalPlane : public Proxy {
 public:
  explicit FocalPlane(const Aperture& aperture) : aperture_(aperture) {}
  std::string Name() const override { return "focal plane"; }
  PlaneInCamera Background(const Rigid3& cam_from_world) const override;

 private:
  Aperture aperture_;
};

std::shared_ptr<const RenderScene> WithFocalPlane(const RenderScene& scene, const Aperture& aperture);

// The point of the proxy that an undistorted camera sees at `img`: what a click focuses on.
Eigen::Vector3d PointOnProxy(const Proxy& proxy, const CameraModel& camera, const Rigid3& cam_from_world,
                             const Eigen::Vector2d& img);

}  // namespace ulf::render
