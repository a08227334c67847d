// Finds the convention that explains poses that do not fit their photographs: programs differ in what a pose
// maps from and to, and in where a camera's axes point.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/rigid3.h"
#include "tracking/estimation/two_view_motion.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

// How well the scene's poses fit matches that were found without them. Two photographs taken side by side
// also fit the poses of cameras that look the other way, but then what they show lies behind them.
struct PoseFit {
  double error_px =
      0;  // median distance from the epipolar lines in most pairs; pixels of the scene's pictures
  // The share of the matches with a determined depth that lie in front of both cameras; 1 where hardly any
  // match near its epipolar line has one.
  double before_share = 1;
};

// Poses with a larger error fit poorly: twice what the worst of ten right sets comes to, pictures at most
// 1000 px a side (docs/measured/tracking.md, "Views whose poses their neighbours contradict").
inline constexpr double kMostFitErrorPx = 1;
// A match farther from its epipolar line is wrong, or its pose is: where its rays meet says nothing. Guessed.
inline constexpr double kMostDepthErrorPx = 3;

// Returns the distances along both rays to where they are nearest to each other; none if too parallel.
std::optional<std::pair<double, double>> DepthsWhereRaysMeet(const Rigid3& second_from_first,
                                                             const RayPair& rays);

// Cameras are taken to look away if a smaller share of the matches lies before them. Guessed.
inline constexpr double kLeastBeforeShare = 0.5;

// Returns whether poses do not fit their photographs: off by more than a pixel, or cameras look away.
bool IsPoor(const PoseFit& fit);

// Returns how well the poses fit the pairs with at least `min_matches` matches; none if there is none.
std::optional<PoseFit> FitOfPoses(const RefineScene& scene, const std::vector<UnguidedPair>& pairs,
                                  std::size_t min_matches);

// Returns the pairs of which most matches agree on one motion of the camera, whatever the poses say; of many
// pairs some are tried. Matches of photographs that show little in common are mostly wrong and agree on none:
// they tell nothing about poses.
std::vector<UnguidedPair> PairsThatAgree(const RefineScene& scene, const std::vector<UnguidedPair>& pairs,
                                         std::size_t min_matches);

// For poses that fit poorly: returns a clause for people that names the convention (inverted, other axes)
// under which they would fit; "" if there is none.
std::string PoseConvention(const RefineScene& scene, const std::vector<UnguidedPair>& pairs,
                           std::size_t min_matches);

}  // namespace ulf::tracking
