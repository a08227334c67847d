// Estimates a lens from the images it took: frees intrinsics in an adjustment, and tests whether the gain is
// more than noise.
//
// Works on a part of a problem: cameras spread evenly over all, and the points that they share. With the lens
// freed the robust cost falls; the Bayesian information criterion (Schwarz 1978) says how much it must fall
// for the additional parameters, after scaling the cost so that most residuals have unit variance. The
// uncertainty comes from the normal equations with all poses and points eliminated: in a flat scene seen from
// one side, or after sideways motion alone, it is large.
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
  double gain = 0;  // decrease of the criterion (twice a natural logarithm): positive is evidence
  // One standard deviation of each free number.
  double focal_sigma_px = 0;
  double principal_point_sigma_px = 0;
  double k1_sigma = 0, k2_sigma = 0;
  // RMS motion of the cameras' centres by freeing it, after an alignment, as a share of the points' distance.
  double centers_moved = 0;
};

// The criterion must fall by more than this before another parameter stays free (very strong evidence; Kass
// and Raftery 1995). Right lenses have shown smaller falls: corners are off by more than noise, and by the
// same in neighbouring views.
inline constexpr double kStrongEvidence = 10;

struct LensEvidenceOptions {
  int max_cameras = 60;
  int max_points = 3000;
  int iterations = 30;
  const std::atomic<bool>* stop = nullptr;  // when set, fits end early and mean nothing
};

// Returns the part of a problem that lens fits work on: observations of one lens that are no outliers.
BundleProblem PartForLens(const BundleProblem& problem, int lens, const LensEvidenceOptions& options = {});

// Fits the lens with each of `choices` free, from the same start, and compares it with the given lens.
std::vector<LensEstimate> FitLens(const CameraModel& given, const BundleProblem& part,
                                  const std::vector<FreeIntrinsics>& choices,
                                  const LensEvidenceOptions& options = {});

// Returns how far the distortion moves the picture's corner, as a share of its distance from the middle: 0.02
// is a pincushion of two percent.
double DistortionAtCorner(const CameraModel& lens);

// Returns whether `fitted` may be a real lens. A map that began under a far too long focal length is bent so
// that it fits longer and longer ones with more and more pincushion: real lenses have up to three percent.
bool IsPlausible(const CameraModel& fitted, const CameraModel& given);

// One step of the choice frees one parameter more than the last that was kept.
struct LensTrial {
  LensEstimate fit;
  double gain_before = 0;  // of the last that was kept
  bool moved = false;      // the new parameter differs by more than so many deviations
  bool kept = false;
  bool plausible = true;  // IsPlausible(); else it is not kept, and nothing is
};

// Returns the lens that the evidence supports: frees focal length, k1, the principal point and k2 one after
// the other, and keeps each for which the evidence is strong enough. Returns none when the given lens stays,
// because the images do not contradict it, or because what would explain them is no lens.
std::optional<LensEstimate> ChooseLens(const CameraModel& given, const BundleProblem& part,
                                       const LensEvidenceOptions& options = {},
                                       std::vector<LensTrial>* trials = nullptr);

}  // namespace ulf::tracking
