// Chooses which views to compare, and matches them.
//
// The poses give the pairs: every view with its nearest ones and, in each direction around it, with one a few
// degrees and one about ten degrees of parallax away. The number of pairs is proportional to the views, and
// they still close a loop of viewpoints. Matches found without the poses measure how good these are. Good
// poses guide the search along epipolar lines; others only choose the pairs, and the two-view geometry must
// agree by itself.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "tracking/features/matching.h"
#include "tracking/refine/refine_scene.h"

namespace ulf::tracking {

struct PairOptions {
  int nearest = 2;  // views that are always compared. Guessed
  // In each quadrant around a view: the views whose parallax is nearest to these angles. Guessed.
  double small_parallax_deg = 4, large_parallax_deg = 11;
  // Views that differ more, in parallax or direction, share too little. Guessed.
  double max_apart_deg = 60;
  double turn_weight = 0.3;  // of the directions' angle beside the parallax. Guessed
};

// Returns pairs of indices of registered views, the smaller first, in order.
std::vector<std::pair<int, int>> ChoosePairs(const RefineScene& scene, const PairOptions& options = {});

// For matches that the two-view geometry confirms. Guessed.
inline constexpr MatchOptions kPairMatching = {.max_distance = 60, .max_ratio = 0.85};

// Returns mutual best matches near each other's epipolar plane, for poses that are good to `band_px`. A
// second best beside the best in the image is the same corner on another level and does not count as a rival.
std::vector<FeatureMatch> MatchAlongEpipolarLines(const FeatureSet& first, const FeatureSet& second,
                                                  const Rigid3& second_from_first, double focal_px,
                                                  double band_px, const MatchOptions& options = {});

struct PairMatches {
  int first = 0, second = 0;
  std::vector<FeatureMatch> matches;
  int alike = 0;  // matches before the geometry was checked
};

// For poses that are off by `error_px`, however much that is: matches corners within a wide band, moves the
// relative pose to where most of them agree, and matches again within a narrow band. None where fewer than
// `min_matches` agree.
PairMatches MatchAroundPose(const RefineScene& scene, int first, int second, double error_px,
                            int min_matches);

// Whether rotations alone explain the matches of nearly all pairs: then nothing can be triangulated.
bool IsOnePlace(const RefineScene& scene, const std::vector<PairMatches>& pairs, unsigned seed);

// One standard deviation, px, of the matches' distances from the epipolar lines of the present poses, from a
// sample of the pairs that are matched without poses; none where hardly anything matches.
std::optional<double> MeasurePoseErrorPx(const RefineScene& scene,
                                         const std::vector<std::pair<int, int>>& pairs);

}  // namespace ulf::tracking
