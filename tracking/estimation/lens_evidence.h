// Estimates a lens from the images that it took: frees intrinsics in a bundle adjustment, and tests whether
// the fit gains more than noise explains.
//
// With intrinsics freed the robust cost falls; the Bayesian information criterion (Schwarz 1978) says how
// much it must fall for the additional parameters, after scaling the cost so that most residuals have unit
// variance. The uncertainty comes from the normal equations with all poses and points eliminated: in a flat
// scene seen from one side, or after sideways motion alone, it is large.
#pragma once

#include <atomic>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::tracking {

struct LensEstimate {
  FreeIntrinsics free;
  CameraModel lens;
  double gain = 0;  // decrease of the criterion from the given lens: positive is evidence for `lens`
  // One standard deviation of each free number; infinite if it is undetermined.
  double focal_sigma_px = 0;
  double principal_point_sigma_px = 0;  // the larger of x and y
  double k1_sigma = 0, k2_sigma = 0;
  // RMS motion of the camera centres by freeing the lens, after a similarity, over the points' distance.
  double centers_moved = 0;
};

// The criterion, twice a natural logarithm, must fall by more than this before another parameter stays free
// (very strong evidence; Kass and Raftery 1995). Right lenses have shown smaller falls: corners are off by
// more than noise, and by the same in neighbouring views.
inline constexpr double kStrongEvidence = 10;

struct LensEvidenceOptions {
  int max_cameras = 60;
  int max_points = 3000;
  int iterations = 30;                      // of each adjustment
  const std::atomic<bool>* stop = nullptr;  // when set, fits end early and mean nothing
};

// Returns the part of a problem from which a lens is estimated: cameras with the lens of index `lens`, spread
// evenly over all, the points that most of them share, and the observations that are no outliers.
BundleProblem PartForLens(const BundleProblem& problem, int lens, const LensEvidenceOptions& options = {});

// Fits the lens with each of `choices` free, from the same start, and compares it with the given lens. Leaves
// out choices whose adjustment fails. Returns nothing for fewer than 3 cameras or 100 observations.
std::vector<LensEstimate> FitLens(const CameraModel& given, const BundleProblem& part,
                                  const std::vector<FreeIntrinsics>& choices,
                                  const LensEvidenceOptions& options = {});

// Returns how far k1 and k2 move the image's farthest corner, as a share of its distance from the principal
// point: 0.02 is a pincushion of two per cent.
double DistortionAtCorner(const CameraModel& lens);

// Returns whether `fitted` may be a real lens: it is not 5 % longer than `given` with 3 % more pincushion. A
// map that began under a far too long focal length fits ever longer ones with more pincushion.
bool IsPlausible(const CameraModel& fitted, const CameraModel& given);

// A step of ChooseLens(): frees one parameter more than the last trial that was kept.
struct LensTrial {
  LensEstimate fit;
  double gain_before = 0;  // of the last trial that was kept
  bool moved = false;      // the new parameter differs by more than three standard deviations
  bool kept = false;
  bool plausible = true;  // IsPlausible()
};

// Returns the lens that the evidence supports: frees focal length, k1, the principal point and k2 one after
// the other, and keeps each that moved and gained more than kStrongEvidence. Returns none if the given lens
// stays, because the images do not contradict it, tell too little, or support only what is no plausible lens.
std::optional<LensEstimate> ChooseLens(const CameraModel& given, const BundleProblem& part,
                                       const LensEvidenceOptions& options = {},
                                       std::vector<LensTrial>* trials = nullptr);

}  // namespace ulf::tracking
