#include "coverage/session/subject_anchors.h"

namespace ulf::coverage {
namespace {

using Eigen::Vector3d;
using tracking::Anchored;

Anchored AnchoredAt(const Vector3d& place_in_world, const tracking::Track& track) {
  const Rigid3& cam_from_world = *track.cam_from_world;
  const Rigid3 place_from_world{cam_from_world.rotation, -(cam_from_world.rotation * place_in_world)};
  Anchored anchored = *track.anchor;
  anchored.cam_from_keyframe = place_from_world * cam_from_world.Inverse() * track.anchor->cam_from_keyframe;
  return anchored;
}

}  // namespace

void SubjectAnchors::Add(const Subject& subject, const tracking::Track& track) {
  if (!track.cam_from_world || !track.anchor) return;
  const Vector3d across = track.cam_from_world->rotation.conjugate() * Vector3d::UnitX();
  anchors_.push_back({AnchoredAt(subject.center_in_world, track),
                      AnchoredAt(subject.center_in_world + subject.radius * across, track)});
}

std::optional<Subject> SubjectAnchors::Now(const tracking::PoseSource& poses) const {
  if (anchors_.empty()) return std::nullopt;
  Subject mean{Vector3d::Zero(), 0};
  const double share = 1.0 / static_cast<double>(anchors_.size());
  for (const Anchor& anchor : anchors_) {
    const Vector3d center = poses.PoseOf(anchor.center).OriginInSource();
    mean.center_in_world += share * center;
    mean.radius += share * (poses.PoseOf(anchor.rim).OriginInSource() - center).norm();
  }
  return mean;
}

}  // namespace ulf::coverage
