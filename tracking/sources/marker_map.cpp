#include "tracking/sources/marker_map.h"

#include <algorithm>

#include "core/base/at.h"
#include "core/geometry/small_matrices.h"
#include "tracking/estimation/two_view_motion.h"
#include "tracking/sources/marker_spec.h"

namespace ulf::tracking {

namespace {

// A place is known when so many proposals agree, of the newest four times as many; they agree within this
// angle and this share of a marker's side. Guessed.
constexpr std::size_t kMarkerMapProposals = 6;
constexpr double kMarkerMapAgreeRad = 0.06;
constexpr double kMarkerMapAgreeShare = 0.5;
// A frame becomes a keyframe when no other lies within this share of the distance and shows its markers.
// Guessed.
constexpr double kMarkerMapKeyframeMoved = 0.05;
constexpr std::size_t kMarkerMapMostKeyframes = 60;
constexpr int kMarkerMapRounds = 5,
              kMarkerMapRoundsAfterGrowth = 20;  // of refinement for a keyframe. Guessed
constexpr double kMarkerMapCornerSigmaPx = 0.5;  // beyond 2.45 of it a corner weighs less. Guessed
constexpr double kMarkerMapHuberPx = 1;          // the same for a marker's pose. Guessed
constexpr int kMarkerMapMinCorners = 8;          // corners that refine a marker's pose: two views'

// Returns the proposal that most others agree with, and how many do.
std::pair<Rigid3, std::size_t> Consensus(const std::vector<Rigid3>& proposals, double agree_m,
                                         double agree_rad) {
  std::pair<Rigid3, std::size_t> best{proposals.front(), 0};
  for (const Rigid3& candidate : proposals) {
    const auto agree = At(std::ranges::count_if(proposals, [&](const Rigid3& other) {
      return (candidate.translation - other.translation).norm() < agree_m &&
             RotationAngle(candidate.rotation.conjugate() * other.rotation) < agree_rad;
    }));
    if (agree > best.second) best = {candidate, agree};
  }
  return best;
}

}  // namespace

std::vector<PointObservation> MarkerMap::Corners(const std::map<int, MarkerImage>& seen,
                                                 double sigma_px) const {
  const auto local = MarkerCorners(side_m_);
  std::vector<PointObservation> corners;
  for (const auto& [id, img] : seen) {
    const auto found = world_from_marker_.find(id);
    if (found == world_from_marker_.end()) continue;
    for (std::size_t k = 0; k < 4; ++k) corners.push_back({found->second * local[k], img[k], sigma_px});
  }
  return corners;
}

void MarkerMap::Add(const Rigid3& cam_from_world, const std::map<int, MarkerImage>& seen,
                    const std::map<int, Rigid3>& cam_from_new) {
  bool grew = false;
  for (const auto& [id, cam_from_marker] : cam_from_new) {
    std::vector<Rigid3>& proposals = proposed_[id];
    proposals.push_back(cam_from_world.Inverse() * cam_from_marker);
    if (proposals.size() > 4 * kMarkerMapProposals) proposals.erase(proposals.begin());
    const auto [place, agree] = Consensus(proposals, kMarkerMapAgreeShare * side_m_, kMarkerMapAgreeRad);
    if (agree < kMarkerMapProposals) continue;
    world_from_marker_[id] = place;
    proposed_.erase(id);
    grew = true;
  }
  // Every new direction and every new set of markers gives a keyframe.
  const auto known = [&](const auto& entry) { return Knows(entry.first); };
  if (std::ranges::count_if(seen, known) < 2) return;
  const double distance = cam_from_world.translation.norm();
  const bool like_another = std::ranges::any_of(keyframes_, [&](const Keyframe& k) {
    return (k.cam_from_world.OriginInSource() - cam_from_world.OriginInSource()).norm() <
               kMarkerMapKeyframeMoved * distance &&
           std::ranges::all_of(seen, [&](const auto& s) { return k.seen.contains(s.first); });
  });
  if (like_another && !grew) return;
  if (keyframes_.size() >= kMarkerMapMostKeyframes)
    keyframes_.erase(keyframes_.begin() + static_cast<std::ptrdiff_t>(kMarkerMapMostKeyframes / 2));
  keyframes_.push_back({cam_from_world, seen});
  Adjust(grew ? kMarkerMapRoundsAfterGrowth : kMarkerMapRounds);
}

void MarkerMap::Adjust(int rounds) {
  constexpr double kNoGate = 1e6;
  const auto local = MarkerCorners(side_m_);
  for (int round = 0; round < rounds; ++round) {
    for (Keyframe& keyframe : keyframes_)
      if (const auto refined = RefinePose(camera_, Corners(keyframe.seen, kMarkerMapCornerSigmaPx),
                                          keyframe.cam_from_world, {.gate_sigmas = kNoGate, .rounds = 1}))
        keyframe.cam_from_world = refined->cam_from_world;
    for (auto& [id, world_from_marker] : world_from_marker_) {
      if (id == first_) continue;
      Eigen::Matrix<double, 6, 6> hessian = Eigen::Matrix<double, 6, 6>::Zero();
      Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
      int corners = 0;
      for (const Keyframe& keyframe : keyframes_) {
        const auto seen = keyframe.seen.find(id);
        if (seen == keyframe.seen.end()) continue;
        const Rigid3 cam_from_marker = keyframe.cam_from_world * world_from_marker;
        for (std::size_t k = 0; k < 4; ++k) {
          Eigen::Matrix<double, 2, 3> img_by_point;
          const auto img = camera_.ImgFromCam(cam_from_marker * local[k], &img_by_point);
          if (!img) continue;
          const Eigen::Vector2d residual = *img - seen->second[k];
          // A twist of the marker's own frame: point -> point + omega x point + v.
          Eigen::Matrix<double, 2, 6> jacobian;
          const Eigen::Matrix<double, 2, 3> by_local = img_by_point * cam_from_marker.RotationMatrix();
          jacobian << -by_local * CrossMatrix(local[k]), by_local;
          const double weight = std::min(1.0, kMarkerMapHuberPx / std::max(1e-9, residual.norm()));
          hessian += weight * jacobian.transpose() * jacobian;
          gradient += weight * jacobian.transpose() * residual;
          ++corners;
        }
      }
      if (corners < kMarkerMapMinCorners) continue;
      const Eigen::Matrix<double, 6, 1> step = -SolveNormal(hessian, gradient);
      if (!step.allFinite()) continue;
      world_from_marker = world_from_marker * Perturbed({}, step);
    }
  }
}

}  // namespace ulf::tracking
