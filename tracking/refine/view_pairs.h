// Chooses which views to compare, and matches them.
//
// The poses give the pairs: every view with its nearest ones and, in each direction around it, with one a few
// degrees and one about ten degrees of parallax away. The number of pairs is proportional to the views, and
// they still close a loop of viewpoints. Matches found without the poses measure how good these are. Good
// poses guide the search along epipolar lines; others only choose the pairs, and the two-view geometry must
// agree by itself.
#pragma once

#include <Eigen/Core>
#include <optional>
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

// Matches that the two-view geometry confirms may be less sure than others. Guessed.
struct EpipolarMatchOptions {
  MatchOptions descriptors = {.max_distance = 60, .max_ratio = 0.85};
  // A second best this close to the best (pixels of level 0, growing with the level) is the same corner on
  // another level, and no rival.
  double same_place_px = 3;
  int levels_apart = 2;  // of a match; more is another thing
};

// Returns mutual best matches near each other's epipolar plane, for poses that are good to `band_px`.
std::vector<FeatureMatch> MatchAlongEpipolarLines(const FeatureSet& first, const FeatureSet& second,
                                                  const Rigid3& second_from_first, double focal_px,
                                                  double band_px, const EpipolarMatchOptions& options = {});

struct PairMatches {
  int first = 0, second = 0;
  std::vector<FeatureMatch> matches;
  int alike = 0;  // matches before the geometry was checked
};

// Guessed, all of it.
struct AgreementOptions {
  double wide_errors = 3, narrow_px = 2.5;  // half widths of the two bands, in errors and in pixels
  // The matches that agree must exceed those by chance this many times, and by so many.
  double chance_times = 3, chance_more = 10;
  // The prior of the relative pose: standard deviations of its turn, in errors, and of its translation, as a
  // share of the baseline. A wider one lets wrong matches pull further.
  double turn_errors = 2, shift = 0.3;
  // Errors beyond the reach weigh less. It shrinks from the poses' error by this factor down to this size,
  // with so many iterations at each. Faster shrinking ends at wrong poses more often.
  double shrink = 0.7, least_reach_px = 0.7;
  int iterations = 4;
};

// For poses that are off by `error_px`, however much that is: matches corners within a wide band, moves the
// relative pose to where most of them agree, and matches again within a narrow band. None where fewer than
// `min_matches` agree.
PairMatches MatchAroundPose(const RefineScene& scene, int first, int second, double error_px, int min_matches,
                            const AgreementOptions& options = {});

struct OnePlaceOptions {
  std::size_t pairs = 24, min_matches = 30;  // pairs that are examined, and matches that each needs. Guessed
  // A rotation explains a match within this distance, a pair by this share of its matches, because some are
  // wrong, and all by this share of the pairs, because neighbours may lie very close together. Guessed.
  double turned_px = 2, match_share = 0.7, pair_share = 0.9;
};

// Whether rotations alone explain the matches of nearly all pairs: then nothing can be triangulated.
bool IsOnePlace(const RefineScene& scene, const std::vector<PairMatches>& pairs, unsigned seed,
                const OnePlaceOptions& options = {});

// Of matches that are found without the poses: surer than others. Guessed.
inline constexpr MatchOptions kUnguidedMatches{.max_distance = 40, .max_ratio = 0.75};

// Matches that are found without the poses, and their distances, px, from the epipolar lines of the present ones. Empty
// where the two views stand in one place.
struct UnguidedPair {
  int first = 0, second = 0;
  std::vector<FeatureMatch> matches;
  std::vector<double> errors_px;  // of the matches
};
UnguidedPair MatchUnguided(const RefineScene& scene, int first, int second,
                           const MatchOptions& options = kUnguidedMatches);

struct PoseErrorOptions {
  std::size_t pairs = 24, min_matches = 20;  // pairs that are examined, and matches that each needs. Guessed
  MatchOptions unguided = kUnguidedMatches;
  double pairs_within = 0.8;  // share of the pairs whose error the result covers. Guessed
};

// One standard deviation, px, of the matches' distances from the epipolar lines of the present poses, from a
// sample of the pairs that are matched without poses; none where hardly anything matches.
std::optional<double> MeasurePoseErrorPx(const RefineScene& scene,
                                         const std::vector<std::pair<int, int>>& pairs,
                                         const PoseErrorOptions& options = {});

}  // namespace ulf::tracking
