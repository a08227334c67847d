// What pictures say about the lens that took them: intrinsics freed in an adjustment, and whether that is
// more than noise.
//
// Works on a part of a problem: cameras spread evenly over all, the points that they share. With the lens
// freed the robust cost falls; by how much it must fall for so many numbers more is the Bayesian information
// criterion (Schwarz 1978), after scaling the cost so that the bulk of the residuals has unit variance. The
// uncertainty comes from the normal equations with all poses and points eliminated: in a flat scene seen from
// one side, or after sideways motion alone, it is large, and the geometry does not tell.
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::tracking {

struct LensEstimate {
  FreeIntrinsics free;
  CameraModel lens;
  double gain = 0;  // fall of the criterion: positive is evidence, natural logarithm times two
  // One standard deviation of each free number.
  double focal_sigma_px = 0;
  double principal_point_sigma_px = 0;
  double k1_sigma = 0, k2_sigma = 0;
};

struct LensEvidenceOptions {
  int max_cameras = 60;
  int max_points = 3000;
  int iterations = 30;
};

// The part of a problem that lens fits work on: observations not marked as outliers, of one lens.
BundleProblem PartForLens(const BundleProblem& problem, int lens, const LensEvidenceOptions& options = {});

// Fits the lens with each of `choices` free (from the same start) and compares with the lens as given.
std::vector<LensEstimate> FitLens(const CameraModel& given, const BundleProblem& part,
                                  const std::vector<FreeIntrinsics>& choices,
                                  const LensEvidenceOptions& options = {});

// One step of the choice: the lens with one number more than the last that was kept.
struct LensTrial {
  LensEstimate fit;
  double gain_before = 0;  // of the last that was kept
  bool moved = false;      // its new number differs by more than three of its sigmas
  bool kept = false;
};

// Of the criterion's fall for one number more (Kass and Raftery 1995). Less has been seen of lenses that were
// right: corners are off by more than noise, and by the same in neighbouring views.
inline constexpr double kVeryStrongEvidence = 10;

// The lens that the evidence speaks for: focal length, then k1, the principal point and k2 are freed one
// after the other, each kept where the evidence is very strong and the number differs by more than three of
// its sigmas. None: the given one stays.
std::optional<LensEstimate> ChooseLens(const CameraModel& given, const BundleProblem& part,
                                       const LensEvidenceOptions& options = {},
                                       std::vector<LensTrial>* trials = nullptr);

}  // namespace ulf::tracking
