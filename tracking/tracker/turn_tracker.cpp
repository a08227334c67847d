#include "tracking/tracker/turn_tracker.h"

#include <algorithm>
#include <utility>

#include "core/base/at.h"
#include "core/geometry/angles.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/relative_pose.h"
#include "tracking/features/matching.h"
#include "tracking/tracker/start_progress.h"

namespace ulf::tracking {

using Eigen::Quaterniond;
using Eigen::Vector2d;

namespace {

// All constants here are guessed.
// A rotation needs so many directions that agree, and this share of the matches.
constexpr int kTurnMinDirections = 30;
constexpr double kTurnMinShare = 0.5;
// Directions agree to within this, px in images 640 px wide: as much parallax as a map starts with.
constexpr double kTurnThresholdPx = 6;
// The search radius about where a direction is expected, as a share of the width, and after a frame without a
// fit.
constexpr double kTurnSearchRadius = 0.12, kTurnSearchRadiusAfterMiss = 0.5;
constexpr int kTurnMaxDistance = kSureDistance + 10;  // bits of a match's descriptors
constexpr double kTurnMaxRatio = 0.85;                // best distance / second best
constexpr double kTurnKeyframeTurnedDeg = 8;          // a frame that is turned farther becomes a keyframe
// Keyframes that a frame is compared with, and after a frame without a fit; keyframes that are kept.
constexpr int kTurnKeyframesTried = 3, kTurnKeyframesTriedAfterMiss = 10;
constexpr std::size_t kTurnMostKeyframes = 200;

double AngleBetween(const Quaterniond& a, const Quaterniond& b) { return RotationAngle(a * b.conjugate()); }

}  // namespace

void TurnTracker::Begin(std::shared_ptr<const FeatureSet> features, const Quaterniond& cam_from_world) {
  keyframes_ = {{std::move(features), cam_from_world}};
  last_ = cam_from_world;
  step_.setIdentity();
}

std::optional<Quaterniond> TurnTracker::Step(const std::shared_ptr<const FeatureSet>& features) {
  if (!HasBegun()) {
    if (features->size() < kFewestFeatures) return std::nullopt;
    Begin(features, Quaterniond::Identity());
    return last_;
  }
  const Quaterniond expected = step_ * last_;
  std::vector<const TurnKeyframe*> nearest;
  for (const TurnKeyframe& keyframe : keyframes_) nearest.push_back(&keyframe);
  std::ranges::sort(nearest, [&](const TurnKeyframe* a, const TurnKeyframe* b) {
    return AngleBetween(a->cam_from_world, expected) < AngleBetween(b->cam_from_world, expected);
  });
  // After a miss the camera may have turned on: more keyframes are tried, directions searched farther away.
  const auto tried = At(missed_ ? kTurnKeyframesTriedAfterMiss : kTurnKeyframesTried);
  std::optional<Fit> best;
  for (std::size_t i = 0; i < std::min(tried, nearest.size()) && !best; ++i)
    best = FitTo(*nearest[i], *features, expected);
  missed_ = !best;
  if (!best) {
    step_.setIdentity();
    return std::nullopt;
  }
  step_ = (best->cam_from_world * last_.conjugate()).normalized();
  last_ = best->cam_from_world;
  const bool far = AngleBetween(nearest.front()->cam_from_world, last_) > Radians(kTurnKeyframeTurnedDeg);
  if (far && keyframes_.size() < kTurnMostKeyframes) keyframes_.push_back({features, last_});
  return last_;
}

std::optional<TurnTracker::Fit> TurnTracker::FitTo(const TurnKeyframe& keyframe, const FeatureSet& features,
                                                   const Quaterniond& expected) const {
  constexpr double kFarAway = -1e6;  // outside of every image: nothing is found there
  const Quaterniond turn = expected * keyframe.cam_from_world.conjugate();
  std::vector<Vector2d> expected_img;
  for (const Feature& feature : keyframe.features->all())
    expected_img.push_back(camera_.ImgFromCam(turn * feature.ray).value_or(Vector2d::Constant(kFarAway)));
  const double radius = missed_ ? kTurnSearchRadiusAfterMiss : kTurnSearchRadius;
  const std::vector<FeatureMatch> matches =
      MatchInWindow(*keyframe.features, features, expected_img, radius * camera_.width,
                    {.max_distance = kTurnMaxDistance, .max_ratio = kTurnMaxRatio});
  if (static_cast<int>(matches.size()) < kTurnMinDirections) return std::nullopt;
  std::vector<RayPair> pairs;
  for (const FeatureMatch& match : matches)
    pairs.push_back({(*keyframe.features)[match.first].ray, features[match.second].ray});
  const double threshold_px = kTurnThresholdPx * PxAt640(camera_.width);
  const Quaterniond found = FitRotation(pairs, camera_.MeanFocalPx(), threshold_px, seed_);
  const double most = threshold_px / camera_.MeanFocalPx();
  const auto agree = std::ranges::count_if(
      pairs, [&](const RayPair& pair) { return (found * pair.first - pair.second).norm() < most; });
  if (agree < kTurnMinDirections ||
      static_cast<double>(agree) < kTurnMinShare * static_cast<double>(pairs.size()))
    return std::nullopt;
  return Fit{(found * keyframe.cam_from_world).normalized(), static_cast<int>(agree)};
}

}  // namespace ulf::tracking
