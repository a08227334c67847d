// Finds the convention that explains poses that do not fit their photographs: programs differ in what a pose
// maps from and to, and in where a camera's axes point.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

// Describes how well the scene's poses fit matches that were found without them. Two photographs taken side
// by side fit the poses of cameras that look the other way, too, but then what they show lies behind them.
struct PoseFit {
  double error_px =
      0;  // median distance from the epipolar lines in most pairs; pixels of the scene's pictures
  // Of the matches whose depth is determined, the share that lies in front of both cameras.
  double before_share = 1;
};

// With a smaller share of matches in front of both cameras, these are taken to look away. Guessed.
inline constexpr double kLeastBeforeShare = 0.5;

// Returns whether the poses do not fit their photographs.
bool IsPoor(const PoseFit& fit);

// Returns how well the poses fit the pairs with at least `min_matches` matches; none without any.
std::optional<PoseFit> FitOfPoses(const RefineScene& scene, const std::vector<UnguidedPair>& pairs,
                                  std::size_t min_matches);

// Returns what convention the poses have that fit poorly as they are, and well once they are changed to the
// format's: a clause for people. It is empty when no such change makes them fit.
std::string PoseConvention(const RefineScene& scene, const std::vector<UnguidedPair>& pairs,
                           std::size_t min_matches);

}  // namespace ulf::tracking
