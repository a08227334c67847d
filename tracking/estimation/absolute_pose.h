// Estimates one camera's pose from known points that it sees: AbsolutePose() without a first guess, from
// three points at a time (P3P) inside the sampler of sampling.h; RefinePose() from a guess.
//
// Errors are distances in the distorted image. RefinePose() divides them by each observation's sigma and
// applies Levenberg-Marquardt with Huber weights to six parameters (a twist in the camera frame); then it
// drops outliers and repeats. It is fast enough to run several times a frame.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf::tracking {

// Normal errors with unit variance in each of two dimensions are shorter than kSigmas95 in 95 % of cases,
// shorter than kMedianLength in half of them.
inline constexpr double kSigmas95 = 2.45;
inline constexpr double kMedianLength = 1.1774;
inline constexpr double kMedianOfNormal = 0.6745;  // the same median in one dimension
inline constexpr double kChi2 = 5.99;              // the square of kSigmas95

// Returns Huber's loss of a squared error; `limit` is the error up to which the loss is quadratic.
inline double HuberCost(double squared, double limit) {
  return squared <= limit * limit ? squared : 2 * limit * std::sqrt(squared) - limit * limit;
}

struct PointObservation {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector2d img = Eigen::Vector2d::Zero();  // where the image shows it, px
  double sigma_px = 1;                            // standard deviation in x and y; AbsolutePose() ignores it
};

struct RefinePoseOptions {
  double huber_sigmas = kSigmas95;  // beyond it an observation weighs less
  double gate_sigmas = kSigmas95;   // an observation that is off by more is an outlier
  int rounds = 3;                   // of refining and dropping outliers. Guessed
  int max_iterations = 8;           // in a round. Guessed
  double min_step = 1e-6;  // a smaller step (radians plus share of the distance) ends a round. Guessed
};

struct PoseRefinement {
  Rigid3 cam_from_world;
  std::vector<bool> inlier;  // by observation
  int inliers = 0;           // number of inliers
  // Covariance of the twist (rotation, translation) in the camera frame if errors have their sigmas.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  // One standard deviation of the camera centre, world units: from the covariance and the actual errors,
  // times a measured factor for what errors have in common.
  double center_sigma = 0;
};

// Returns none if fewer than four observations remain or the geometry does not determine a pose.
std::optional<PoseRefinement> RefinePose(const CameraModel& camera,
                                         std::span<const PointObservation> observations,
                                         const Rigid3& initial_cam_from_world,
                                         const RefinePoseOptions& options = {});

struct AbsolutePoseOptions {
  double threshold_px = 4;   // largest reprojection error of an inlier
  int min_inliers = 12;      // fewer give no pose
  int max_iterations = 500;  // samples of three observations
  unsigned seed = 1;
};

struct AbsolutePoseResult {
  Rigid3 cam_from_world;
  std::vector<int> inliers;  // indices of observations
  int iterations = 0;
};

// Estimates the pose from observations of which many may be wrong. Returns none if fewer than `min_inliers`
// agree, or if a clearly different pose explains them about as well.
std::optional<AbsolutePoseResult> AbsolutePose(const CameraModel& camera,
                                               std::span<const PointObservation> observations,
                                               const AbsolutePoseOptions& options = {});

// Moves the camera by a twist in its own frame: rotates by its first three entries (a rotation vector,
// radians), then adds the last three to the translation.
Rigid3 Perturbed(const Rigid3& cam_from_world, const Eigen::Matrix<double, 6, 1>& twist);

}  // namespace ulf::tracking
