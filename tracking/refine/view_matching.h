// Reads recorded views and matches pairs of them: the first steps of refining and of triangulating.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tracking/refine/refine_input.h"
#include "tracking/refine/refine_scene.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

// Poses that are off by more do not show where to search for a match. Guessed.
inline constexpr double kGuidingErrorPx = 2.5;
// Fewer matches of a pair may all be wrong. Guessed.
inline constexpr int kMinPairMatches = 15;
// Few views can afford more corners and points, and need them. Guessed.
inline constexpr std::size_t kFewViews = 100;

// A part of the work and its share of the progress.
struct RefineStage {
  const std::function<void(double share, const std::string& stage)>& progress;
  double from = 0, to = 1;
  // The part of it from one share to another.
  RefineStage Part(double first, double end) const {
    return {progress, from + (to - from) * first, from + (to - from) * end};
  }
  void Show(double share, const std::string& what) const {
    if (progress) progress(from + (to - from) * share, what);
  }
};

struct ReadingOptions {
  int max_side_px = 1600;  // larger pictures are reduced
  int corners = 1500;      // a view, about
  // Of the pyramid: the views of a set differ more in distance than frames that follow each other. Measured:
  // docs/tracking_measured.md, "Published sets".
  int levels = kPyramidLevels;
  // Corners where masks show nothing of the world of the poses: matched without these, a standing background before which
  // the subject turned would speak against all of them.
  bool masked = true;
  // Neighbouring views whose corners share one adapting threshold, whatever the number of threads: more look
  // less alike, fewer give each processor less to do. Guessed.
  int in_a_row = 8;
};

// Reads every view and describes its corners. A view that cannot be read is not registered and says why.
RefineScene ReadScene(const RefineInput& input, const ReadingOptions& options, const RefineStage& stage);

struct PairMatchingOptions {
  // Half width of the band about an epipolar line, in errors of the poses, and at least: a wider one holds
  // more wrong matches, a narrower one misses right ones. Guessed.
  double band_errors = 4, least_band_px = 2;
};

// Matches along epipolar lines where the poses are good to a few pixels (kGuidingErrorPx); else moves the
// relative poses first (MatchAroundPose).
std::vector<PairMatches> MatchPairs(const RefineScene& scene, const std::vector<std::pair<int, int>>& pairs,
                                    double error_px, const RefineStage& stage,
                                    const PairMatchingOptions& options = {});

}  // namespace ulf::tracking
