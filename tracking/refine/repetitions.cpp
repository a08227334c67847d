#include "tracking/refine/repetitions.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "tracking/estimation/two_view_motion.h"
#include "tracking/refine/pose_conventions.h"

namespace ulf::tracking {
namespace {

// From this share of matches on a scene is repetitive. Scenes that repeat themselves came to 0.3 and more,
// others to at most 0.1.
constexpr double kRepetitiveShare = 0.2;
// Poses explain a part of the matches that is set apart if it is at least this share of them, and so many
// times as dense on the epipolar lines as beside them. Guessed.
constexpr double kLeastExplainedShare = 0.25, kLeastPeak = 3;

// A match of a pair under two poses.
struct JudgedMatch {
  double error_px = 0;
  bool may_be_seen = true;  // its point lies before both cameras, or its rays are too parallel to tell
  // At the same place of both pictures: something that moves with the camera, or a background that stands
  // still behind a turntable, and no repetition.
  bool stands_still = false;
  bool IsNear() const { return may_be_seen && error_px < kMostDepthErrorPx; }
  bool IsExplained() const { return may_be_seen && error_px < kMostFitErrorPx; }
};

std::vector<JudgedMatch> JudgedUnder(const Rigid3& first_from_world, const RefineScene& scene,
                                     const UnguidedPair& pair) {
  const RefineView &first = scene.view(pair.first), &second = scene.view(pair.second);
  const Rigid3 second_from_first = second.cam_from_world * first_from_world.Inverse();
  const Eigen::Matrix3d essential = EssentialFromPose(second_from_first);
  const double focal_px = scene.LensOf(first).MeanFocalPx();
  std::vector<JudgedMatch> judged;
  for (const FeatureMatch& match : pair.matches) {
    const RayPair rays{first.features[match.first].ray.normalized(),
                       second.features[match.second].ray.normalized()};
    const auto depths = DepthsWhereRaysMeet(second_from_first, rays);
    judged.push_back({EpipolarError(essential, rays) * focal_px,
                      !depths || (depths->first > 0 && depths->second > 0),
                      (rays.first - rays.second).norm() * focal_px < kMostDepthErrorPx});
  }
  return judged;
}

std::vector<JudgedMatch> Judged(const RefineScene& scene, const UnguidedPair& pair) {
  return JudgedUnder(scene.view(pair.first).cam_from_world, scene, pair);
}

bool IsPartExplained(const std::vector<JudgedMatch>& matches) {
  const auto on_line = static_cast<double>(std::ranges::count_if(matches, &JudgedMatch::IsExplained)),
             near = static_cast<double>(std::ranges::count_if(matches, &JudgedMatch::IsNear));
  return on_line >= kLeastExplainedShare * static_cast<double>(matches.size()) &&
         on_line / kMostFitErrorPx >= kLeastPeak * (near - on_line) / (kMostDepthErrorPx - kMostFitErrorPx);
}

// Keeps the matches for which `keeps` is true, by index.
template <typename Keeps>
void KeepIf(UnguidedPair& pair, const Keeps& keeps) {
  UnguidedPair kept{pair.first, pair.second, {}, {}};
  for (std::size_t m = 0; m < pair.matches.size(); ++m) {
    if (!keeps(m)) continue;
    kept.matches.push_back(pair.matches[m]);
    kept.errors_px.push_back(pair.errors_px[m]);
  }
  pair = std::move(kept);
}

}  // namespace

Repetitions::Repetitions(const RefineScene& scene, const std::vector<UnguidedPair>& pairs)
    : scene_(scene), repeats_(scene.views.size()) {
  ParallelFor(repeats_.size(), [&](std::size_t v) {
    const FeatureSet& features = scene.views[v].features;
    for (int i = 0; i < features.size(); ++i)
      repeats_[v].push_back(tracking::IsRepetitive(features, i, kUnguidedMatches.max_distance));
  });
  double all = 0, repeated = 0;
  for (const UnguidedPair& pair : pairs)
    for (const FeatureMatch& match : pair.matches) {
      ++all;
      repeated += Repeats(pair, match) ? 1 : 0;
    }
  share_ = repeated / std::max(1.0, all);
}

bool Repetitions::IsRepetitive() const { return share_ >= kRepetitiveShare; }

bool Repetitions::Repeats(const UnguidedPair& pair, const FeatureMatch& match) const {
  return repeats_[At(pair.first)][At(match.first)] || repeats_[At(pair.second)][At(match.second)];
}

void Repetitions::DropFrom(UnguidedPair& pair) const {
  if (!IsRepetitive()) return;
  std::vector<JudgedMatch> judged = Judged(scene_, pair);
  if (!IsPartExplained(judged)) {
    KeepIf(pair, [&](std::size_t m) { return !Repeats(pair, pair.matches[m]); });
    judged = Judged(scene_, pair);
  }
  if (IsPartExplained(judged))
    KeepIf(pair, [&](std::size_t m) { return judged[m].stands_still || judged[m].IsNear(); });
}

bool Repetitions::ConfirmAgainst(int view, int neighbour, std::span<const int> corners,
                                 const Rigid3& other_cam_from_world) const {
  if (!IsRepetitive()) return false;
  UnguidedPair pair{view, neighbour, {}, {}};
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (corners[i] >= 0) pair.matches.push_back({static_cast<int>(i), corners[i], 0});
  const std::vector<JudgedMatch> judged = Judged(scene_, pair),
                                 by_other = JudgedUnder(other_cam_from_world, scene_, pair);
  std::size_t explained = 0, by_both = 0;
  for (std::size_t m = 0; m < judged.size(); ++m) {
    explained += judged[m].IsExplained();
    by_both += judged[m].IsExplained() && by_other[m].IsNear();
  }
  return explained > 0 && IsPartExplained(judged) && 4 * by_both < explained;
}

}  // namespace ulf::tracking
