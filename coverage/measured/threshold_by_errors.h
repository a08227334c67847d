// Raises or lowers the bound's threshold in each direction from a subject by the errors that were measured at
// frames: views stand farther apart where pictures turn out better than the goal, and closer together where
// they turn out worse. Where nothing was measured the threshold stays.
//
// A frame tells at which spacing of the views its error would meet the goal: errors fall by kDbPerHalving
// when the nearest view is half as far away. Frames nearby are averaged, so that the recorded views still
// form an even lattice, which needs the fewest of them.
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
  static constexpr double kMostApart = Radians(12);  // the largest disc radius: geometry needs neighbours
  static constexpr double kUsualApart = 0.6;  // frames' average angle to the nearest view, in disc radii
  // `disc_radius`: the angle that one view covers by `threshold_px` (CoverageMap::DiscRadius()), radians.
  ThresholdByErrors(const ErrorMap& errors, const CoverGoal& goal, double threshold_px, double disc_radius);

  // Returns the factor on the threshold in a direction, for CoverageMap::SetThresholdFactor(). It is at most
  // 1 where the bound must be met as well (CoverBy::kBoth).
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

// Adapts a map's threshold to what was measured, unless the bound alone decides or there is no view. The map
// must have options that WithAdaptiveThreshold() returned.
void AdaptThresholds(const ErrorMap& errors, const CoverGoal& goal, CoverageMap& map);
CoverageMapOptions WithAdaptiveThreshold(CoverageMapOptions options, const CoverGoal& goal);

// Returns the light field's map with the thresholds that its capture ended with. `map`: by the bound alone.
CoverageMap CoverageByErrors(const MeasuredErrors& measured, const CoverageMap& map);

}  // namespace ulf::coverage
