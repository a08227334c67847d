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

// 95 % of the errors of unit variance in two dimensions are shorter (the square root of 5.99), half of them
// are shorter than the median.
inline constexpr double kSigmas95 = 2.45;
inline constexpr double kMedianLength = 1.1774;
inline constexpr double kChi2 = 5.99;  // 95 % quantile of their squares

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
  // Squared error that counts for a point that cannot be projected: a smaller one makes steps that lose
  // points look cheap. Guessed.
  double lost_point_sigmas2 = 1e4;
  // For center_sigma: the true error over the one that independent errors of the residuals' size would make
  // (measured: docs/tracking_measured.md, "What the quality value says"), and the least residual, in sigmas,
  // because few residuals can be small by chance (guessed).
  double common_error = 1.5, least_residual = 0.1;
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

// None when fewer than four observations remain or the geometry does not determine a pose.
std::optional<PoseRefinement> RefinePose(const CameraModel& camera,
                                         std::span<const PointObservation> observations,
                                         const Rigid3& initial_cam_from_world,
                                         const RefinePoseOptions& options = {});

// The search for another pose that explains the matches about as well. Guessed.
struct RivalPoseOptions {
  // Poses are clearly different whose turns differ by more, or whose centres do, as a share of the distance.
  double different_turn_deg = 5, different_shift = 0.05;
  // Samples that are drawn, those of the largest area that propose poses, and rivals that are refined: more
  // find more rivals and cost time.
  std::size_t drawn = 60, used = 8, refined = 6;
  // A rival counts whose cost is worse by less than this many variances of the noise, or than this many an
  // inlier; more refuses more poses, less accepts more wrong ones.
  double least_margin = 60, margin_per_inlier = 0.25;
  double least_noise_px = 0.1;
};

struct AbsolutePoseOptions {
  double threshold_px = 4;
  int min_inliers = 12;
  int max_iterations = 500;
  unsigned seed = 1;
  RivalPoseOptions rivals = {};
};

struct AbsolutePoseResult {
  Rigid3 cam_from_world;
  std::vector<int> inliers;
  int iterations = 0;
};

// Estimates the pose from matches of which many may be wrong. None without `min_inliers` that agree, or where
// a clearly different pose explains the matches about as well.
std::optional<AbsolutePoseResult> AbsolutePose(const CameraModel& camera,
                                               std::span<const PointObservation> observations,
                                               const AbsolutePoseOptions& options = {});

// exp(twist) applied on the left: rotation then translation of the camera frame.
Rigid3 Perturbed(const Rigid3& cam_from_world, const Eigen::Matrix<double, 6, 1>& twist);

}  // namespace ulf::tracking
