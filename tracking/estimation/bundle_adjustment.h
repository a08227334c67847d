// Adjusts poses and points so that together they explain all observations best (Triggs et al. 2000), with
// Ceres. Image quantities are pixels, poses cam_from_world in any unit.
//
// It minimises the sum of Huber-weighted squared reprojection errors over their sigmas, then drops
// observations that no longer fit and repeats. Most errors are far below their sigmas, but a patch that is
// seen from the side, or lies over an edge in depth, is off by much more, and by the same in neighbouring
// views. Where the start is good, Cauchy's loss on the scale of the errors themselves (their median) keeps
// such errors from bending the poses.
//
// Gauge: cameras marked fixed stay. With none fixed the first camera is, unless known points hold the world.
// With a single fixed camera the scale is restored afterwards. The solver has one thread and is therefore
// repeatable: several threads would add in varying order.
//
// Intrinsics may be free: all cameras of one lens share them. With few free cameras the reduced system is
// solved dense, with many by conjugate gradients (Agarwal et al. 2010), which is far faster where every view
// sees the same things, as in a light field (measured: docs/measured/charts/bundle_adjustment.png).
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
  Eigen::Vector2d img = Eigen::Vector2d::Zero();
  double sigma_px = 1;
  bool outlier = false;  // set by AdjustBundle: left out of the last solution
};

// Describes how a camera with a rolling shutter moved while its rows were read (rolling_shutter.h): an
// unknown that is held to what is known otherwise.
struct RowsMotion {
  Twist twist = Twist::Zero();
  Twist prior = Twist::Zero(), prior_sigma = Twist::Ones();
};

struct BundleProblem {
  std::vector<Rigid3> cam_from_world;
  std::vector<bool> fixed;  // by camera
  std::vector<int> lens;    // by camera, index into the camera models; empty: all have the first
  std::vector<Eigen::Vector3d> points;
  std::vector<bool> known;  // by point: it stays; points beyond the end are free
  std::vector<BundleObservation> observations;
  // A rolling shutter's readout time, s, and the motion by camera. Image points of a camera without motion
  // were taken at once, those of the others are where the sensor saw them. Intrinsics must then be held.
  double readout_s = 0;
  std::vector<std::optional<RowsMotion>> rows = {};
};

// The solver of the reduced system (points eliminated).
enum class BundleSolver { kBySize, kDense, kSparse, kIterative };

// kBySize solves problems with up to so many free cameras dense. Measured:
// docs/measured/charts/bundle_adjustment.png.
inline constexpr int kDenseCameras = 120;

struct BundleOptions {
  int robust_iterations = 5;  // before outliers are dropped
  int iterations = 10;        // after
  double huber_sigmas = kSigmas95;
  // The width of Cauchy's loss, which replaces Huber's, in units of the errors' own scale; 0: Huber's loss
  double cauchy_scales = 0;
  double gate_sigmas = kSigmas95;
  // An observation off by more than so many times the errors' own scale is an outlier, too; 0: no gate.
  double gate_scales = 0;
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
  double initial_rms_sigmas = 0;  // root mean square error over sigma
  double final_rms_sigmas = 0;    // of the observations kept
  int outliers = 0;
  // The camera with the smallest share of kept observations: below one half they contradict its pose; -1:
  // none.
  int least_kept_camera = -1;
  double least_kept = 1;
  int iterations = 0;
  std::string message;
};

BundleSummary AdjustBundle(const CameraModel& camera, BundleProblem& problem,
                           const BundleOptions& options = {});

// Adjusts a problem with several lenses, whose intrinsics change where they are free.
BundleSummary AdjustBundle(std::vector<CameraModel>& lenses, BundleProblem& problem,
                           const BundleOptions& options = {});

// Returns one standard deviation of the errors in units of their sigmas, robustly from the median.
double ErrorScale(const std::vector<CameraModel>& lenses, const BundleProblem& problem);

// Error of an observation over its sigma, squared; 1e8 where the point cannot be projected.
double SquaredErrorSigmas(const std::vector<CameraModel>& lenses, const BundleProblem& problem,
                          const BundleObservation& seen);

}  // namespace ulf::tracking
