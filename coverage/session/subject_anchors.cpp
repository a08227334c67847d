#include "coverage/session/subject_anchors.h"

#include <algorithm>

#include "core/geometry/angles.h"
#include "core/geometry/small_matrices.h"

namespace ulf::coverage {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using tracking::Anchored;

Vector3d PlaceInWorld(const Anchored& camera, const Vector3d& in_cam, const tracking::PoseSource& poses) {
  Anchored place = camera;
  place.cam_from_keyframe.translation -= in_cam;
  return poses.PoseOf(place).OriginInSource();
}

Vector3d DirectionOf(const Subject& subject, const Rigid3& cam_from_world) {
  return (cam_from_world.OriginInSource() - subject.center_in_world).normalized();
}

}  // namespace

void SubjectAnchors::Add(const Subject& subject, const tracking::Track& track) {
  if (!track.cam_from_world || !track.anchor) return;
  anchors_.push_back({*track.anchor, *track.cam_from_world * subject.center_in_world, subject.radius,
                      DirectionOf(subject, *track.cam_from_world)});
}

bool SubjectAnchors::StandsApart(const Subject& subject, const Rigid3& cam_from_world,
                                 double least_angle) const {
  const Vector3d direction = DirectionOf(subject, cam_from_world);
  return std::ranges::all_of(anchors_, [&](const Anchor& anchor) {
    return AngleBetween(direction, anchor.direction) >= least_angle;
  });
}

std::optional<Subject> SubjectAnchors::Now(const tracking::PoseSource& poses) const {
  if (anchors_.empty()) return std::nullopt;
  Subject mean{Vector3d::Zero(), 0};
  const double share = 1.0 / static_cast<double>(anchors_.size());
  for (const Anchor& anchor : anchors_) {
    const Vector3d center = PlaceInWorld(anchor.camera, anchor.center, poses);
    const Vector3d rim = anchor.center + anchor.radius * Vector3d::UnitX();
    mean.center_in_world += share * center;
    mean.radius += share * (PlaceInWorld(anchor.camera, rim, poses) - center).norm();
  }
  return mean;
}

std::optional<Subject> SubjectAnchors::ReplaceLens(const CameraModel& now, const CameraModel& before,
                                                   const tracking::PoseSource& poses) {
  struct Sighting {
    Anchor* anchor;
    Rigid3 cam_from_world;
    double unit;                   // the world's now, in the anchor's
    Vector3d center_ray, rim_ray;  // of depth 1
  };
  std::vector<Sighting> sightings;
  // What the cameras' rays leave open along them, since all stand on one side, a weak guess decides: the lens
  // changed depths as it changed the focal length, because baselines stayed. It counts as much as rays that
  // meet under this angle, radians. Guessed.
  constexpr double kGuessCounts = 0.02;
  Matrix3d weights = Matrix3d::Zero();
  Vector3d weighted = Vector3d::Zero();
  for (Anchor& anchor : anchors_) {
    const Rigid3 pose = poses.PoseOf(anchor.camera);
    const Vector3d center_before = pose * PlaceInWorld(anchor.camera, anchor.center, poses);
    const auto ray_through = [&](const Vector3d& in_cam) -> std::optional<Vector3d> {
      const auto img = before.ImgFromCam(in_cam);
      const auto ray = img ? now.RayFromImg(*img) : std::nullopt;
      return ray && ray->z() > 0 ? std::optional<Vector3d>(*ray / ray->z()) : std::nullopt;
    };
    const auto center = ray_through(anchor.center);
    const auto rim = ray_through(anchor.center + anchor.radius * Vector3d::UnitX());
    if (!center || !rim) continue;
    sightings.push_back({&anchor, pose, anchor.center.norm() / center_before.norm(), *center, *rim});
    const Vector3d along = pose.rotation.conjugate() * center->normalized();
    const Vector3d origin = pose.OriginInSource();
    const double guess = center_before.z() * center->norm() * now.MeanFocalPx() / before.MeanFocalPx();
    const Matrix3d across = Matrix3d::Identity() - along * along.transpose();
    const double share = kGuessCounts * kGuessCounts;
    weights += across + share * along * along.transpose();
    weighted += across * origin + share * along * along.dot(origin + guess * along);
  }
  if (sightings.empty()) return std::nullopt;
  Subject subject{SolveNormal(weights, weighted), 0};
  for (const Sighting& seen : sightings) {
    const double depth = (seen.cam_from_world * subject.center_in_world).z();
    subject.radius += depth * (seen.rim_ray - seen.center_ray).norm() / static_cast<double>(sightings.size());
  }
  std::vector<Anchor> gone_over;
  for (const Sighting& seen : sightings)
    gone_over.push_back({seen.anchor->camera, seen.unit * (seen.cam_from_world * subject.center_in_world),
                         seen.unit * subject.radius, DirectionOf(subject, seen.cam_from_world)});
  anchors_ = std::move(gone_over);
  return subject;
}

}  // namespace ulf::coverage
