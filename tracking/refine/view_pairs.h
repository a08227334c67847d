// Which views are compared, and what they have in common.
//
// Pairs come from the poses: every view with its nearest ones and, in each direction around it, with one a
// few degrees and one about ten degrees of parallax away: a number of pairs proportional to the views, which
// a loop of viewpoints still closes. How good the poses are is measured first, on matches found without them;
// poses that are good let each corner be looked for along its epipolar line, others are only asked which
// views to compare, and the two-view geometry must then agree on its own.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "tracking/features/matching.h"
#include "tracking/refine/refine_scene.h"

namespace ulf::tracking {

// Indices of registered views, the smaller first, in order.
std::vector<std::pair<int, int>> ChoosePairs(const RefineScene& scene);

// Mutual best matches near each other's epipolar plane, by poses that are good to `band_px`. A second best
// beside the best in the image is the same corner on another level and no rival.
std::vector<FeatureMatch> MatchAlongEpipolarLines(const FeatureSet& first, const FeatureSet& second,
                                                  const Rigid3& second_from_first, double focal_px,
                                                  double band_px, const MatchOptions& options = {});

struct PairMatches {
  int first = 0, second = 0;
  std::vector<FeatureMatch> matches;
  int alike = 0;  // corners that look alike, before the geometry had its say
};

// From poses that are good to `error_px` only, however many pixels that is: corners within a wide band are
// matched, the relative pose is moved to where most of them agree, and those matched again closely there.
// None where fewer than `min_matches` agree.
PairMatches MatchAroundPose(const RefineScene& scene, int first, int second, double error_px,
                            int min_matches);

// Whether turning alone explains what the pairs have in common: then there is nothing to triangulate.
bool IsOnePlace(const RefineScene& scene, const std::vector<PairMatches>& pairs, unsigned seed);

// How far matches lie from the epipolar lines of the present poses, px, as one standard deviation, from a
// sample of the pairs matched without poses; none where hardly anything matches.
std::optional<double> MeasurePoseErrorPx(const RefineScene& scene,
                                         const std::vector<std::pair<int, int>>& pairs);

}  // namespace ulf::tracking
