#include "tracking/tracker/initializer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/small_matrices.h"
#include "tracking/features/patch_alignment.h"

namespace ulf::tracking {
namespace {

// The median parallax of the two views that start a map, at least. Smaller angles leave the depths open,
// larger ones make the operator wait. Guessed.
constexpr double kStartMinParallaxDeg = 0.8;
// Matches between the two views; fewer start again from a new reference. Guessed.
constexpr int kStartMinMatches = 60;
// Share of the matches that give points, at least. Measured: 0.98 and more where a scene stands still; less
// than 0.75 where half of it moves, or tiles are taken for their neighbours.
constexpr double kStartMinPointShare = 0.85;
// A match lies within this share of the image's width of where its feature was last seen. Guessed.
constexpr double kStartSearchRadius = 0.08;
constexpr int kStartMaxDistance = kSureDistance + 10;  // bits. Guessed
constexpr double kStartMaxRatio = 0.85;                // best distance / second best. Guessed
// A part of the image (a twelfth) that lies off the epipolar lines to one side by more than this, in the
// median of at least so many matches, moves on its own. Measured: less than half of it where a scene stands
// still, drawn and recorded.
constexpr double kStartMaxPartShiftPx = 1;
constexpr int kStartMinPartMatches = 8;

// Returns the ray of a match in the second view, aligned with the first view's patch where that works:
// detected corners alone are too coarse for the small parallax at the start. The patch is warped by rotation
// only.
Eigen::Vector3d AlignedRay(const CameraModel& camera, const Feature& from, const Pyramid& first,
                           const Feature& to, const Pyramid& second) {
  const auto patch = CutPatch(first, from.img, from.level);
  const auto axes = AxesOf(camera, Rigid3{}, from.ray, from.level);
  if (!patch || !axes) return to.ray;
  const Rigid3 turned{TurnBetween(from.ray, to.ray), Eigen::Vector3d::Zero()};
  const auto aligned = AlignPatch(camera, *patch, *axes, from.ray, turned, second, to.img);
  if (!aligned) return to.ray;
  return camera.RayFromImg(aligned->img).value_or(to.ray);
}

// Returns whether a part of the image moves on its own: lies off the motion's epipolar lines to one side. Two
// motions can look like one for a while, because depth explains all motion along the lines. Motion across
// them remains; it has one sign where one thing moves, while errors of matches have both.
bool PartMovesOnItsOwn(const CameraModel& camera, const Rigid3& second_from_first,
                       std::span<const Eigen::Vector2d> first_img, std::span<const RayPair> pairs) {
  constexpr int kColumns = 4, kRows = 3;
  const double most_px = kStartMaxPartShiftPx * PxAt640(camera.width);
  const Eigen::Matrix3d essential = EssentialFromPose(second_from_first);
  std::array<std::vector<double>, kColumns * kRows> off_px;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d line = essential * pairs[i].first;
    const double across = std::hypot(line.norm(), (essential.transpose() * pairs[i].second).norm());
    if (!(across > 0)) continue;
    off_px[CellOf(first_img[i], camera, kColumns, kRows)].push_back(camera.MeanFocalPx() *
                                                                    pairs[i].second.dot(line) / across);
  }
  return std::ranges::any_of(off_px, [&](const std::vector<double>& part) {
    return part.size() >= At(kStartMinPartMatches) && std::abs(Median(part)) > most_px;
  });
}

// Sets `progress` where it returns true.
bool TooFewFeatures(const TrackedImage& image, StartProgress& progress) {
  if (image.features->size() >= kFewestFeatures) return false;
  progress.obstacle = StartObstacle::kTooFewFeatures;
  progress.matches = image.features->size();
  progress.matches_needed = kFewestFeatures;
  return true;
}

StartObstacle ObstacleOf(const RelativePoseResult& relative) {
  switch (relative.outcome) {
    case RelativePoseOutcome::kFound:
      return StartObstacle::kNone;
    case RelativePoseOutcome::kTooFewMatches:
    case RelativePoseOutcome::kTooFewPoints:
      return StartObstacle::kTooFewMatches;
    case RelativePoseOutcome::kRotationOnly:
      return StartObstacle::kRotationOnly;
    case RelativePoseOutcome::kLowParallax:
      return StartObstacle::kLowParallax;
    case RelativePoseOutcome::kConflicting:
      return StartObstacle::kConflictingMotions;
    case RelativePoseOutcome::kAmbiguous:
      break;
  }
  return relative.model == RelativePoseModel::kHomography ? StartObstacle::kAmbiguousPlane
                                                          : StartObstacle::kLowParallax;
}

}  // namespace

void Initializer::SetReference(const TrackedImage& image) {
  reference_ = image;
  expected_.clear();
  for (const Feature& feature : image.features->all()) expected_.push_back(feature.img);
  seen_s_.assign(expected_.size(), image.time_s);
  flow_.assign(expected_.size(), Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
}

InitializerAttempt Initializer::Step(const TrackedImage& image) {
  InitializerAttempt attempt;
  StartProgress& progress = attempt.progress;
  progress.matches_needed = kStartMinMatches;
  progress.parallax_needed_deg = kStartMinParallaxDeg;
  if (!reference_) {
    if (TooFewFeatures(image, progress)) return attempt;
    SetReference(image);
    return attempt;
  }
  const FeatureSet &first = *reference_->features, &second = *image.features;
  const std::vector<FeatureMatch> matches =
      MatchInWindow(first, second, expected_, kStartSearchRadius * camera_.width,
                    {.max_distance = kStartMaxDistance, .max_ratio = kStartMaxRatio});
  progress.matches = static_cast<int>(matches.size());
  if (progress.matches < kStartMinMatches) {
    progress.obstacle = StartObstacle::kTooFewMatches;
    reference_.reset();
    if (!TooFewFeatures(image, progress)) SetReference(image);
    return attempt;
  }
  std::vector<RayPair> pairs;
  std::vector<double> motion_px;
  std::vector<Eigen::Vector2d> flow, first_img;
  for (const FeatureMatch& match : matches) {
    const Feature &from = first[match.first], &to = second[match.second];
    pairs.push_back({from.ray, AlignedRay(camera_, from, *reference_->pyramid, to, *image.pyramid)});
    first_img.push_back(from.img);
    Eigen::Vector2d& expected = expected_[At(match.first)];
    const Eigen::Vector2d moved = second[match.second].img - expected;
    motion_px.push_back(moved.norm());
    expected = second[match.second].img;
    double& seen_s = seen_s_[At(match.first)];
    flow.push_back(moved / (image.time_s - seen_s));
    if (Eigen::Vector2d& at_first = flow_[At(match.first)]; seen_s == reference_->time_s)
      at_first = flow.back();
    seen_s = image.time_s;
  }
  attempt.median_motion_px = Median(std::move(motion_px));

  RelativePoseResult relative = RelativePose(pairs, {.focal_px = camera_.MeanFocalPx(),
                                                     .min_parallax_deg = kStartMinParallaxDeg,
                                                     .min_point_share = kStartMinPointShare,
                                                     .seed = seed_});
  if (relative.outcome == RelativePoseOutcome::kFound &&
      PartMovesOnItsOwn(camera_, relative.second_from_first, first_img, pairs))
    relative.outcome = RelativePoseOutcome::kConflicting;
  attempt.outcome = relative.outcome;
  progress.obstacle = ObstacleOf(relative);
  progress.parallax_deg = relative.median_parallax_deg;
  progress.parallax_needed_deg = relative.parallax_needed_deg;
  attempt.direction_sigma_deg = relative.direction_sigma_deg;
  attempt.model = relative.model;
  attempt.evidence = relative.evidence;
  if (relative.outcome != RelativePoseOutcome::kFound) return attempt;
  TwoViewStart start{*reference_, image, relative.second_from_first, {}, {}, {}, {}, {}, {}};
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (relative.points_in_first[i]) {
      start.matches.push_back(matches[i]);
      start.points.push_back(*relative.points_in_first[i]);
      start.first_flow.push_back(flow_[At(matches[i].first)]);
      start.second_flow.push_back(flow[i]);
    }
  attempt.start = std::move(start);
  return attempt;
}

}  // namespace ulf::tracking
