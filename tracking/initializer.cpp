#include "tracking/initializer.h"

#include <algorithm>
#include <cmath>

namespace ulf {
namespace {

constexpr int kMinFeatures = 80;
constexpr int kMinMatches = 60;

}  // namespace

Initializer::Initializer(const CameraModel& camera, double min_parallax_deg, unsigned seed)
    : camera_(camera), min_parallax_deg_(min_parallax_deg), seed_(seed) {}

void Initializer::SetReference(const TrackedImage& image) {
  reference_ = image;
  expected_.clear();
  for (const Feature& feature : image.features->all()) expected_.push_back(feature.img);
}

InitializerAttempt Initializer::Step(const TrackedImage& image) {
  InitializerAttempt attempt;
  if (!reference_) {
    if (image.features->size() >= kMinFeatures) SetReference(image);
    return attempt;
  }
  const FeatureSet &first = *reference_->features, &second = *image.features;
  const double radius_px = 0.08 * camera_.width;
  const std::vector<FeatureMatch> matches = MatchInWindow(
      first, second, expected_, radius_px, {.max_distance = kSureDistance + 10, .max_ratio = 0.85});
  attempt.matches = static_cast<int>(matches.size());
  if (attempt.matches < kMinMatches) {
    reference_.reset();
    if (second.size() >= kMinFeatures) SetReference(image);
    return attempt;
  }
  std::vector<RayPair> pairs;
  std::vector<double> motion_px;
  for (const FeatureMatch& match : matches) {
    pairs.push_back({first[match.first].ray, second[match.second].ray});
    Eigen::Vector2d& expected = expected_[static_cast<std::size_t>(match.first)];
    motion_px.push_back((second[match.second].img - expected).norm());
    expected = second[match.second].img;
  }
  std::nth_element(motion_px.begin(), motion_px.begin() + static_cast<long>(motion_px.size() / 2),
                   motion_px.end());
  attempt.median_motion_px = motion_px[motion_px.size() / 2];

  const RelativePoseResult relative = RelativePose(
      pairs, {.focal_px = camera_.MeanFocalPx(), .min_parallax_deg = min_parallax_deg_, .seed = seed_});
  attempt.outcome = relative.outcome;
  attempt.median_parallax_deg = relative.median_parallax_deg;
  if (relative.outcome != RelativePoseOutcome::kFound) return attempt;
  TwoViewStart start{*reference_, image, relative.second_from_first, {}, {}};
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (relative.points_in_first[i]) {
      start.matches.push_back(matches[i]);
      start.points.push_back(*relative.points_in_first[i]);
    }
  attempt.start = std::move(start);
  return attempt;
}

}  // namespace ulf
