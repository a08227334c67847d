#include "coverage/measured/threshold_by_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace ulf::coverage {
namespace {

// Guessed.
constexpr double kErrorsMostOneSided = 0.7;   // beyond the views errors are larger than between them
constexpr double kErrorsWeightOfUnknown = 2;  // in frames
constexpr double kErrorsLeastApart = 0.35;    // as kUsualApart: nearer frames do not count
// Standard deviation of the weights of frames around a direction.
constexpr double kErrorsReach = Radians(3.5);

}  // namespace

using Eigen::Vector3d;

ThresholdByErrors::ThresholdByErrors(const ErrorMap& errors, const CoverGoal& goal, double threshold_px,
                                     double disc_radius)
    : least_(std::min(1.0, kLeast_px / threshold_px)), most_(std::max(1.0, kMost_px / threshold_px)) {
  if (goal.by == CoverBy::kBoth) most_ = 1;
  most_ = std::min(most_, kMostApart / disc_radius);
  least_ = std::min(least_, most_);
  std::map<std::array<int, 3>, Region> regions;
  for (const ErrorMap::Part* part : errors.Parts()) {
    const MeasuredFrame& frame = part->frame;
    if (!frame.measurable || frame.one_sided > kErrorsMostOneSided ||
        part->view_angle_now < kErrorsLeastApart * disc_radius)
      continue;
    const double above_goal_db = part->DbNow() - goal.db;
    if (above_goal_db < 0 && !frame.IsOfTheLightField()) continue;
    const double factor_log2 =
        std::log2(part->view_angle_now / (kUsualApart * disc_radius)) + above_goal_db / kDbPerHalving;
    const Vector3d at = frame.direction / kErrorsReach;
    Region& region = regions[{static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())),
                              static_cast<int>(std::lround(at.z()))}];
    region.direction += frame.direction;
    region.sum_log2 += std::clamp(factor_log2, std::log2(least_), std::log2(most_));
    ++region.frames;
  }
  for (auto& [key, region] : regions) {
    region.direction.normalize();
    regions_.push_back(region);
  }
}

double ThresholdByErrors::operator()(const Vector3d& direction) const {
  constexpr double kFarthest = 3;  // standard deviations
  const double least_cosine = std::cos(kFarthest * kErrorsReach);
  double sum = 0, weights = kErrorsWeightOfUnknown;
  for (const Region& region : regions_) {
    const double cosine = region.direction.dot(direction);
    if (cosine < least_cosine) continue;
    // cos a is about 1 - a^2 / 2.
    const double weight = std::exp((cosine - 1) / (kErrorsReach * kErrorsReach));
    sum += weight * region.sum_log2;
    weights += weight * region.frames;
  }
  return std::clamp(std::exp2(sum / weights), least_, most_);
}

void AdaptThresholds(const ErrorMap& errors, const CoverGoal& goal, CoverageMap& map) {
  if (goal.by == CoverBy::kBound || map.views().empty()) return;
  map.SetThresholdFactor(ThresholdByErrors(errors, goal, map.options().threshold_px, map.DiscRadius()));
}

CoverageMapOptions WithAdaptiveThreshold(CoverageMapOptions options, const CoverGoal& goal) {
  if (goal.by == CoverBy::kMeasured)
    options.most_threshold_factor = std::max(1.0, ThresholdByErrors::kMost_px / options.threshold_px);
  // The grid stays finer than a third of the smallest disc.
  if (goal.by != CoverBy::kBound)
    options.cells_per_disc_radius *= std::max(1.0, options.threshold_px / ThresholdByErrors::kLeast_px);
  return options;
}

CoverageMap CoverageByErrors(const MeasuredErrors& measured, const CoverageMap& map) {
  const CoverGoal goal{CoverByNamed(measured.cover), measured.goal_db};
  CoverageMap by_errors(map.subject(), WithAdaptiveThreshold(map.options(), goal), map.views());
  AdaptThresholds(ErrorMapOf(measured), goal, by_errors);
  return by_errors;
}

}  // namespace ulf::coverage
