#include "tracking/tracker/turn_tracker.h"

#include <algorithm>
#include <cmath>

#include "core/base/at.h"
#include "core/geometry/angles.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/relative_pose.h"
#include "tracking/features/matching.h"

namespace ulf::tracking {

using Eigen::Quaterniond;
using Eigen::Vector2d;

namespace {

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
  std::sort(nearest.begin(), nearest.end(), [&](const TurnKeyframe* a, const TurnKeyframe* b) {
    return AngleBetween(a->cam_from_world, expected) < AngleBetween(b->cam_from_world, expected);
  });
  // After a miss the camera may have turned on: more keyframes, and directions looked for farther away.
  const auto tried = At(missed_ ? options_.keyframes_tried_after_miss : options_.keyframes_tried);
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
  const bool far =
      AngleBetween(nearest.front()->cam_from_world, last_) > Radians(options_.keyframe_turned_deg);
  if (far && keyframes_.size() < options_.most_keyframes) keyframes_.push_back({features, last_});
  return last_;
}

std::optional<TurnTracker::Fit> TurnTracker::FitTo(const TurnKeyframe& keyframe, const FeatureSet& features,
                                                   const Quaterniond& expected) const {
  constexpr double kFarAway = -1e6;  // outside of every image: nothing is found there
  const Quaterniond turn = expected * keyframe.cam_from_world.conjugate();
  std::vector<Vector2d> expected_img;
  for (const Feature& feature : keyframe.features->all())
    expected_img.push_back(camera_.ImgFromCam(turn * feature.ray).value_or(Vector2d::Constant(kFarAway)));
  const double radius = missed_ ? options_.search_radius_after_miss : options_.search_radius;
  const std::vector<FeatureMatch> matches =
      MatchInWindow(*keyframe.features, features, expected_img, radius * camera_.width,
                    {.max_distance = options_.max_distance, .max_ratio = options_.max_ratio});
  if (static_cast<int>(matches.size()) < options_.min_directions) return std::nullopt;
  std::vector<RayPair> pairs;
  for (const FeatureMatch& match : matches)
    pairs.push_back({(*keyframe.features)[match.first].ray, features[match.second].ray});
  const double threshold_px = options_.threshold_px * PxAt640(camera_.width);
  const Quaterniond found = FitRotation(pairs, camera_.MeanFocalPx(), threshold_px, seed_);
  const double most = threshold_px / camera_.MeanFocalPx();
  const auto agree = std::count_if(pairs.begin(), pairs.end(), [&](const RayPair& pair) {
    return (found * pair.first - pair.second).norm() < most;
  });
  if (agree < options_.min_directions ||
      static_cast<double>(agree) < options_.min_share * static_cast<double>(pairs.size()))
    return std::nullopt;
  return Fit{(found * keyframe.cam_from_world).normalized(), static_cast<int>(agree)};
}

}  // namespace ulf::tracking
