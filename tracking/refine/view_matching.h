// Reads recorded views and matches pairs of them: the first steps of refining and of triangulating. Defines
// the thresholds that both use.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tracking/refine/refine_input.h"
#include "tracking/refine/refine_scene.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

// Poses that are off by more do not tell where to search for a match. Guessed.
inline constexpr double kGuidingErrorPx = 2.5;
// Fewer matches of a pair may all be wrong. Guessed.
inline constexpr int kMinPairMatches = 15;
// Up to so many views get more corners and points, which they need and can afford. Guessed.
inline constexpr std::size_t kFewViews = 100;

// The error of start poses that is assumed where hardly anything matches. Guessed.
inline constexpr double kMostStartErrorPx = 40;
// The gate of triangulation is the first factor times the start poses' error, at least the second value;
// after a first adjustment it is the third factor times the error left. Wider ones let in wrong matches,
// narrower ones lose right ones. Guessed.
inline constexpr double kGateErrors = 6, kLeastGatePx = 4, kRepeatedGateErrors = 8;
// Iterations of the first adjustment from good and from bad start poses, of the first with repeated matches,
// and of all later ones. Guessed.
inline constexpr int kGuidedIterations = 10, kUnguidedIterations = 60, kRepeatedIterations = 30,
                     kLaterIterations = 12;
// For settled poses, in units of the errors' own scale: the width of Cauchy's loss (measured:
// docs/measured/tracking.md, "Cauchy's loss"), and the gate, beyond which 0.03 % of normal errors lie.
inline constexpr double kSettledCauchyScales = 2, kSettledGateScales = 4;

// A part of the work, which takes the progress from one share of the whole (0 to 1) to another.
struct RefineStage {
  const std::function<void(double share, const std::string& stage)>& progress;
  double from = 0, to = 1;
  // Returns the part of the stage from one share to another.
  RefineStage Part(double first, double end) const {
    return {progress, from + (to - from) * first, from + (to - from) * end};
  }
  void Show(double share, const std::string& what) const {
    if (progress) progress(from + (to - from) * share, what);
  }
};

struct ReadingOptions {
  int max_side_px = 1600;  // to which the longer side of larger pictures is reduced
  int corners = 1500;      // about the number a view
  // Keeps corners that masks exclude. A check of poses drops them: matches on a standing background before
  // which the subject turned would contradict all poses.
  bool keeps_masked = true;
};

// Reads every view and detects its corners. A view that cannot be read is not registered and says why.
RefineScene ReadScene(const RefineInput& input, const ReadingOptions& options, const RefineStage& stage);

// Matches pairs of views whose poses are off by `error_px`: along epipolar lines if that is below
// kGuidingErrorPx, else by MatchAroundPose(). Pairs with fewer than kMinPairMatches matches get none.
std::vector<PairMatches> MatchPairs(const RefineScene& scene, const std::vector<std::pair<int, int>>& pairs,
                                    double error_px, const RefineStage& stage);

}  // namespace ulf::tracking
