// From recorded views to what pairs of them have in common: the first steps of refining and of triangulating.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tracking/refine/refine.h"
#include "tracking/refine/refine_scene.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

// Poses off by more do not show where to look for a match.
inline constexpr double kGuidingErrorPx = 2.5;
inline constexpr int kMinPairMatches = 15;

// A part of the work, for whoever shows how far it is.
struct RefineStage {
  const std::function<void(double share, const std::string& stage)>& progress;
  double from = 0, to = 1;
  void Show(double share, const std::string& what) const {
    if (progress) progress(from + (to - from) * share, what);
  }
};

// Views with the lenses of their working resolution; nothing is read yet.
RefineScene SceneOf(const RefineInput& input, int max_side_px);

// Along epipolar lines where poses are good to a few pixels, else with the relative poses moved first.
std::vector<PairMatches> MatchPairs(const RefineScene& scene, const std::vector<std::pair<int, int>>& pairs,
                                    double error_px, const RefineStage& stage);

}  // namespace ulf::tracking
