// Raises or lowers the bound's threshold in each direction from a subject by the errors that were measured at
// frames: views stand farther apart where pictures turn out better than the goal, and closer together where
// they turn out worse. Where nothing was measured the threshold stays.
//
// A frame tells at which spacing of the views its error would meet the goal: errors fall by kDbPerHalving
// with half the distance to the nearest view. Frames nearby are averaged, so that views that are recorded by
// the threshold still form an even lattice, which needs the fewest of them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/angles.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/measured/cover_by.h"
#include "coverage/measured/error_map.h"

namespace ulf::coverage {

class ThresholdByErrors {
 public:
  // All guessed. The threshold goes no further than from the quality "high" to three times "fast".
  static constexpr double kLeast_px = kHighThresholdPx, kMost_px = 36;
  static constexpr double kMostApart = Radians(12);  // between views: geometry needs neighbours
  // The average distance of frames from the nearest view, in shares of the radius that the bound lets one
  // view cover.
  static constexpr double kUsualApart = 0.6;
  // `disc_radius`: that one view covers by `threshold_px` (CoverageMap::DiscRadius()), radians.
  ThresholdByErrors(const ErrorMap& errors, const CoverGoal& goal, double threshold_px, double disc_radius);

  // CoverageMap's ThresholdFactor. At most 1 where the bound must be met as well (CoverBy::kBoth).
  double operator()(const Eigen::Vector3d& direction) const;

 private:
  // The frames of a small part of the sphere.
  struct Region {
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    double sum_log2 = 0;  // of the factors that they ask for
    int frames = 0;
  };
  double least_, most_;  // factors
  std::vector<Region> regions_;
};

// Adapts a map's threshold to what was measured, unless the bound alone decides or there is no view.
void AdaptThresholds(const ErrorMap& errors, const CoverGoal& goal, CoverageMap& map);
// Returns options for a map whose threshold will be adapted.
CoverageMapOptions WithAdaptiveThreshold(CoverageMapOptions options, const CoverGoal& goal);

// Returns the map of a light field as its own capture had it in the end.
CoverageMap CoverageByErrors(const MeasuredErrors& measured, const CoverageMap& map);

}  // namespace ulf::coverage
