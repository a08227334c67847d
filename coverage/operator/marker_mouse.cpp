#include "coverage/operator/marker_mouse.h"

#include <algorithm>
#include <utility>

#include "core/base/quantile.h"

namespace ulf::coverage {

MarkerMouse::MarkerMouse(const render::RenderScene& scene, const Eigen::Vector3d& middle) : middle_(middle) {
  const Eigen::Vector3d& subject = scene.subject.center_in_world;
  Eigen::Vector3d front = Eigen::Vector3d::Zero();
  std::vector<double> distances;
  for (const render::SceneView& view : scene.views) {
    front += (view.center_in_world - subject).normalized();
    distances.push_back((view.center_in_world - subject).norm());
  }
  distance_ = Median(std::move(distances));
  // Views all around have no front: the first one's is as good as any.
  if (front.norm() < 0.05 * static_cast<double>(scene.views.size()))
    front = scene.views.front().center_in_world - subject;
  held_from_world_ = LookAt(subject, subject - front, scene.up_in_world);
}

Rigid3 MarkerMouse::CamFromWorld(const Rigid3& cam_from_marker) {
  const Eigen::Vector3d middle_in_cam = cam_from_marker * middle_;
  if (!world_per_metre_) world_per_metre_ = distance_ / std::max(1e-6, middle_in_cam.norm());
  // Seen from where the camera is, but aimed: a marker held off the middle is not a subject off the picture.
  const auto aimed = Eigen::Quaterniond::FromTwoVectors(middle_in_cam, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d ahead(0, 0, *world_per_metre_ * middle_in_cam.norm());
  return Rigid3{(aimed * cam_from_marker.rotation).normalized(), ahead} * held_from_world_;
}

}  // namespace ulf::coverage
