// Chooses which views to compare, and matches them.
//
// The poses give the pairs: every view with its nearest ones and, in each direction around it, with one a few
// degrees and one about ten degrees of parallax away. The number of pairs is proportional to the views, and
// they still close a loop of viewpoints. Matches found without the poses measure how good the poses are. Good
// ones guide the search along epipolar lines; others only choose the pairs, and the matches must agree on a
// two-view geometry by themselves.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "tracking/features/matching.h"
#include "tracking/refine/refine_scene.h"

namespace ulf::tracking {

struct PairOptions {
  int nearest = 2;  // number of nearest views that are always compared. Guessed
  // In each quadrant a view is compared with those whose parallax is nearest to these angles. Guessed.
  double small_parallax_deg = 4, large_parallax_deg = 11;
};

// Returns pairs of indices of registered views, the smaller first, ascending.
std::vector<std::pair<int, int>> ChoosePairs(const RefineScene& scene, const PairOptions& options = {});

// Returns mutual best matches among features within `band_px` of each other's epipolar line.
std::vector<FeatureMatch> MatchAlongEpipolarLines(const FeatureSet& first, const FeatureSet& second,
                                                  const Rigid3& second_from_first, double focal_px,
                                                  double band_px);

struct PairMatches {
  int first = 0, second = 0;  // indices of views
  std::vector<FeatureMatch> matches;
  int alike = 0;  // number of matches before the geometry was checked
};

// Matches two views whose poses are off by `error_px`, however much that is: matches corners within a wide
// band, moves the relative pose to where most of them agree, and matches again within a narrow band. Returns
// no matches if fewer than `min_matches` agree, or hardly more than by chance.
PairMatches MatchAroundPose(const RefineScene& scene, int first, int second, double error_px,
                            int min_matches);

// Returns whether rotations alone explain the matches of nearly all pairs: then nothing can be triangulated.
bool IsOnePlace(const RefineScene& scene, const std::vector<PairMatches>& pairs, unsigned seed);

// Thresholds of matches that are found without the poses: they must be surer than others. Guessed.
inline constexpr MatchOptions kUnguidedMatches{.max_distance = 40, .max_ratio = 0.75};

// Matches that are found without the poses, and their distances, px, from the epipolar lines of the present
// poses. There are none if the poses put both views in one place.
struct UnguidedPair {
  int first = 0, second = 0;
  std::vector<FeatureMatch> matches;
  std::vector<double> errors_px;  // of the matches
};
UnguidedPair MatchUnguided(const RefineScene& scene, int first, int second,
                           const MatchOptions& options = kUnguidedMatches);

// Returns one standard deviation, px, of the distances from the epipolar lines of the present poses: of
// matches that are found without the poses, in a sample of the pairs, of which four fifths are not worse.
// Returns none if hardly anything matches.
std::optional<double> MeasurePoseErrorPx(const RefineScene& scene,
                                         const std::vector<std::pair<int, int>>& pairs);

}  // namespace ulf::tracking
