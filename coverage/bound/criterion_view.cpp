#include "coverage/bound/criterion_view.h"

#include <Eigen/Geometry>

namespace ulf::coverage {

using Eigen::Vector3d;

CriterionView CriterionView::From(const CameraModel& camera, const Rigid3& cam_from_world,
                                  int coverage_width_px) {
  const double scale = static_cast<double>(coverage_width_px) / camera.width;
  CriterionView view;
  view.center_in_world = cam_from_world.OriginInSource();
  view.cam_from_world = cam_from_world.RotationMatrix();
  view.fx = camera.fx * scale;
  view.fy = camera.fy * scale;
  view.cx = camera.cx * scale;
  view.cy = camera.cy * scale;
  view.width = camera.width * scale;
  view.height = camera.height * scale;
  return view;
}

CriterionView CriterionView::AimedAt(const Vector3d& target_in_world, const Vector3d& center,
                                     const Vector3d& up_in_world) const {
  CriterionView view = *this;
  view.center_in_world = center;
  const Vector3d forward = (target_in_world - center).normalized();
  Vector3d right = forward.cross(up_in_world);
  if (right.squaredNorm() < 1e-18 * up_in_world.squaredNorm()) right = forward.unitOrthogonal();
  right.normalize();
  view.cam_from_world.row(0) = right;
  view.cam_from_world.row(1) = forward.cross(right);
  view.cam_from_world.row(2) = forward;
  return view;
}

}  // namespace ulf::coverage
