// Estimates one camera's pose from map points it sees: without a guess (P3P inside the seeded sampler), and
// by refinement of a guess.
//
// Errors are reprojection errors in distorted pixels, divided by each observation's sigma. The refinement is
// Levenberg-Marquardt over six parameters (a twist in the camera frame) with Huber weights; then it drops
// outliers and repeats. It is fast enough to run several times a frame.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf::tracking {

// 95 % of errors of unit variance in two dimensions are shorter than the first (the square root of 5.99),
// half of them shorter than the second.
inline constexpr double kSigmas95 = 2.45;
inline constexpr double kMedianLength = 1.1774;
// Half of the errors of unit variance in one dimension are smaller.
inline constexpr double kMedianOfNormal = 0.6745;
inline constexpr double kChi2 = 5.99;  // 95 % quantile of the squared errors in two dimensions

// Huber's loss of a squared error, quadratic up to `limit`.
inline double HuberCost(double squared, double limit) {
  return squared <= limit * limit ? squared : 2 * limit * std::sqrt(squared) - limit * limit;
}

struct PointObservation {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector2d img = Eigen::Vector2d::Zero();
  double sigma_px = 1;
};

struct RefinePoseOptions {
  double huber_sigmas = kSigmas95;  // beyond it an observation weighs less
  double gate_sigmas = kSigmas95;   // an observation that is off by more is an outlier
  int rounds = 3;                   // of refining and gating. Guessed
  int max_iterations = 8;           // in a round. Guessed
  double min_step = 1e-6;  // a smaller step (radians plus share of the distance) ends a round. Guessed
};

struct PoseRefinement {
  Rigid3 cam_from_world;
  std::vector<bool> inlier;  // by observation
  int inliers = 0;
  // Covariance of the twist (rotation, translation) in the camera frame, for unit sigma observations.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  // One standard deviation of the camera centre, world units, from geometry, residuals and measured error.
  double center_sigma = 0;
};

// Returns none when fewer than four observations remain or the geometry does not determine a pose.
std::optional<PoseRefinement> RefinePose(const CameraModel& camera,
                                         std::span<const PointObservation> observations,
                                         const Rigid3& initial_cam_from_world,
                                         const RefinePoseOptions& options = {});

struct AbsolutePoseOptions {
  double threshold_px = 4;
  int min_inliers = 12;
  int max_iterations = 500;
  unsigned seed = 1;
};

struct AbsolutePoseResult {
  Rigid3 cam_from_world;
  std::vector<int> inliers;
  int iterations = 0;
};

// Estimates the pose from matches of which many may be wrong. Returns none without `min_inliers` that agree,
// or where a clearly different pose explains the matches about as well.
std::optional<AbsolutePoseResult> AbsolutePose(const CameraModel& camera,
                                               std::span<const PointObservation> observations,
                                               const AbsolutePoseOptions& options = {});

// Applies exp(twist) on the left: rotation, then translation of the camera frame.
Rigid3 Perturbed(const Rigid3& cam_from_world, const Eigen::Matrix<double, 6, 1>& twist);

}  // namespace ulf::tracking
