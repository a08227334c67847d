// Poses and points that together explain all observations best (Triggs et al. 2000), solved by Ceres.
//
// Minimises the sum of Huber-weighted squared reprojection errors over their sigmas, then drops observations
// that no longer fit and repeats. Most errors are far below their sigmas, but a patch that is seen from the
// side, or lies over an edge in depth, is off by a lot and by the same in neighbouring views: where the start
// is good, Cauchy's loss on the scale of the errors themselves (their median) keeps those from bending the
// poses. The gauge: cameras marked fixed stay; with none fixed the first one is,
// unless points are known, which say where everything is; with a single fixed camera the scale is restored
// afterwards, so that nothing floats. Single-threaded, hence repeatable: with several threads Ceres adds in
// the order in which they come.
//
// Intrinsics may be free: all cameras of one lens share them. Up to 120 free cameras the reduced system is
// solved dense, beyond by conjugate gradients (Agarwal et al. 2010), which is far faster where every view
// sees the same things, as in a light field.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/free_intrinsics.h"

namespace ulf::tracking {

struct BundleObservation {
  int camera = 0;  // indices into the problem
  int point = 0;
  Eigen::Vector2d img = Eigen::Vector2d::Zero();
  double sigma_px = 1;
  bool outlier = false;  // set by AdjustBundle: left out of the last solution
};

struct BundleProblem {
  std::vector<Rigid3> cam_from_world;
  std::vector<bool> fixed;  // by camera
  std::vector<int> lens;    // by camera, index into the camera models; empty: all have the first
  std::vector<Eigen::Vector3d> points;
  std::vector<bool> known;  // by point: it stays where it is; shorter: the rest do not
  std::vector<BundleObservation> observations;
};

// Of the reduced system, points eliminated.
enum class BundleSolver { kBySize, kDense, kSparse, kIterative };

struct BundleOptions {
  int robust_iterations = 5;  // before outliers are dropped
  int iterations = 10;        // after
  double huber_sigmas = 2.45;
  // In place of Huber's: Cauchy's loss, which begins to doubt at so many times the errors' own scale. 0:
  // Huber.
  double cauchy_scales = 0;
  double gate_sigmas = 2.45;
  // Observations farther off than so many times the errors' own scale go, too. 0: only gate_sigmas counts.
  double gate_scales = 0;
  const std::atomic<bool>* stop = nullptr;  // ends early, keeping what was reached
  FreeIntrinsics free = {};                 // of every lens
  BundleSolver solver = BundleSolver::kBySize;
  double function_tolerance = 1e-5;        // relative change of the cost that ends a solution
  std::function<void(int)> progress = {};  // after every iteration, with how many there were
};

struct BundleSummary {
  // The solver came to something, and no fewer than half of the observations agree with it (where more do
  // not, they may as well be the ones that are right). Otherwise everything is as it was.
  bool usable = false;
  bool settled = false;           // the last solution ended by itself: more iterations would change little
  double initial_rms_sigmas = 0;  // root mean square error over sigma
  double final_rms_sigmas = 0;    // of the observations kept
  int outliers = 0;
  // Of the views that have any observations the one that keeps the smallest share of them: where less than
  // half agree, what it sees contradicts where it was put. -1: none.
  int least_kept_camera = -1;
  double least_kept = 1;
  int iterations = 0;
  std::string message;
};

BundleSummary AdjustBundle(const CameraModel& camera, BundleProblem& problem,
                           const BundleOptions& options = {});

// The same for several lenses, whose intrinsics change where they are free.
BundleSummary AdjustBundle(std::vector<CameraModel>& lenses, BundleProblem& problem,
                           const BundleOptions& options = {});

// What one standard deviation of the errors really is, in sigmas: from their median, so that a few large ones
// do not count.
double ErrorScale(const std::vector<CameraModel>& lenses, const BundleProblem& problem);

// Error of an observation over its sigma, squared; 1e8 where the point cannot be projected.
double SquaredErrorSigmas(const std::vector<CameraModel>& lenses, const BundleProblem& problem,
                          const BundleObservation& seen);

}  // namespace ulf::tracking
