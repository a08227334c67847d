// Bundle adjustment: changes poses and points so that together they explain all observations best (Triggs et
// al. 2000), with Ceres. A camera here is one view; a lens is a CameraModel that cameras share.
//
// AdjustBundle() minimises the sum of squared reprojection errors over their sigmas under Huber's loss, then
// drops observations that do not fit and repeats. Most errors are far below their sigmas, but a patch that is
// seen from the side, or lies over an edge in depth, is off by much more, and by the same in neighbouring
// views. If the start is good, Cauchy's loss on the scale of the errors themselves (`cauchy_scales`) keeps
// such errors from bending the poses.
//
// Gauge: fixed cameras and known points stay. If there are none, the first camera is fixed; with a single
// fixed camera and no known point, the scale is restored afterwards. The solver has one thread, so that sums
// have one order and the result is repeatable.
//
// With few free cameras the reduced system (points eliminated) is solved dense, with many by conjugate
// gradients (Agarwal et al. 2010), which is far faster if every view sees the same things, as in a light
// field (measured: docs/measured/charts/bundle_adjustment.png).
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/free_intrinsics.h"
#include "tracking/estimation/rolling_shutter.h"

namespace ulf::tracking {

struct BundleObservation {
  int camera = 0;  // indices into the problem
  int point = 0;
  Eigen::Vector2d img = Eigen::Vector2d::Zero();  // px
  double sigma_px = 1;
  bool outlier = false;  // left out of the first solution if set before; AdjustBundle() sets it anew
};

// The velocity of a camera while its rows were read (rolling_shutter.h): an unknown held to a prior.
struct RowsMotion {
  Twist twist = Twist::Zero();
  Twist prior = Twist::Zero(), prior_sigma = Twist::Ones();
};

struct BundleProblem {
  std::vector<Rigid3> cam_from_world;   // by camera, in any unit
  std::vector<bool> fixed;              // by camera; cameras beyond the end are free
  std::vector<int> lens;                // by camera, index into the lenses; empty: all have the first
  std::vector<Eigen::Vector3d> points;  // in the world
  std::vector<bool> known;              // by point, says that it stays; points beyond the end are free
  std::vector<BundleObservation> observations;
  // The readout time of a rolling shutter, s, and the motion by camera. Observations of a camera with a
  // motion are where the sensor saw them, those of other cameras as a global shutter would have. With
  // motions, no intrinsics may be free.
  double readout_s = 0;
  std::vector<std::optional<RowsMotion>> rows = {};
};

// The solver of the reduced system. kBySize: kDense for up to `dense_cameras` free cameras, else kIterative.
enum class BundleSolver { kBySize, kDense, kSparse, kIterative };
inline constexpr int kDenseCameras = 120;  // measured: docs/measured/charts/bundle_adjustment.png

struct BundleOptions {
  int robust_iterations = 5;  // of the first solution, before outliers are dropped
  int iterations = 10;        // of the second solution; 0: there is none
  double huber_sigmas = kSigmas95;
  // The width of Cauchy's loss, which replaces Huber's, in units of ErrorScale(); 0: Huber's loss.
  double cauchy_scales = 0;
  double gate_sigmas = kSigmas95;  // an observation that is off by more is an outlier
  double gate_scales = 0;  // so is one that is off by more times ErrorScale(); 0: there is no such gate
  const std::atomic<bool>* stop = nullptr;  // when set, ends early and keeps what was reached
  FreeIntrinsics free = {};                 // of every lens
  BundleSolver solver = BundleSolver::kBySize;
  int dense_cameras = kDenseCameras;
  double function_tolerance = 1e-5;        // relative change of the cost that ends a solution
  std::function<void(int)> progress = {};  // called after every iteration with their number
};

struct BundleSummary {
  // At least half of the observations agree with the solution. Otherwise the problem is unchanged.
  bool usable = false;
  bool settled = false;           // the last solution converged: more iterations would change little
  double initial_rms_sigmas = 0;  // root mean square of errors over sigma, without outliers
  double final_rms_sigmas = 0;
  int outliers = 0;
  // The camera that keeps the smallest share of its observations (less than one half contradicts its pose),
  // and that share; -1: there are no observations.
  int least_kept_camera = -1;
  double least_kept = 1;
  int iterations = 0;
  std::string message;  // the solver's, or why the result is not usable
};

// Adjusts a problem of one lens, whose intrinsics stay as they are.
BundleSummary AdjustBundle(const CameraModel& camera, BundleProblem& problem,
                           const BundleOptions& options = {});

// Adjusts a problem, and the intrinsics of `lenses` that are free.
BundleSummary AdjustBundle(std::vector<CameraModel>& lenses, BundleProblem& problem,
                           const BundleOptions& options = {});

// Returns the standard deviation of the errors over their sigmas, from the median; outliers do not count.
double ErrorScale(const std::vector<CameraModel>& lenses, const BundleProblem& problem);

// Returns the square of an observation's error over its sigma; 1e8 if the point cannot be projected.
double SquaredErrorSigmas(const std::vector<CameraModel>& lenses, const BundleProblem& problem,
                          const BundleObservation& seen);

}  // namespace ulf::tracking
