#include "coverage/operator/marker_mouse.h"

#include <algorithm>

#include "core/base/quantile.h"
#include "core/geometry/small_matrices.h"

namespace ulf::coverage {

MarkerMouse::MarkerMouse(const render::RenderScene& scene, const Eigen::Vector3d& middle) : middle_(middle) {
  const Eigen::Vector3d& subject = scene.subject.center_in_world;
  Eigen::Vector3d front = Eigen::Vector3d::Zero();
  for (const render::SceneView& view : scene.views) front += (view.center_in_world - subject).normalized();
  distance_ = Median(DistancesTo(scene.subject, scene.views, &render::SceneView::center_in_world));
  // Views all around have no mean direction: the first view's is used.
  constexpr double kNoFront = 0.05;  // length of the mean direction; guessed
  if (front.norm() < kNoFront * static_cast<double>(scene.views.size()))
    front = scene.views.front().center_in_world - subject;
  held_from_world_ = LookAt(subject, subject - front, scene.up_in_world);
}

Rigid3 MarkerMouse::CamFromWorld(const Rigid3& cam_from_marker) {
  const Eigen::Vector3d middle_in_cam = cam_from_marker * middle_;
  if (!world_per_metre_) world_per_metre_ = distance_ / std::max(1e-6, middle_in_cam.norm());
  // The camera's place, but aimed at the subject: a marker beside the middle must not move the subject out of
  // view.
  const auto aimed = TurnBetween(middle_in_cam, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d ahead(0, 0, *world_per_metre_ * middle_in_cam.norm());
  return Rigid3{(aimed * cam_from_marker.rotation).normalized(), ahead} * held_from_world_;
}

}  // namespace ulf::coverage
