// One camera's pose from map points it sees: found from nothing (P3P inside our sampler), and refined from a
// guess.
//
// Errors are reprojection errors in distorted pixels, divided by each observation's sigma. The refinement is
// Levenberg-Marquardt over six parameters (a twist in the camera frame) with Huber weights, then gates
// outliers and repeats: lean enough to run several times a frame.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf::tracking {

struct PointObservation {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector2d img = Eigen::Vector2d::Zero();
  double sigma_px = 1;
};

struct RefinePoseOptions {
  double huber_sigmas = 2.45;  // sqrt(5.99): 95 % of Gaussian errors in two dimensions
  double gate_sigmas = 2.45;   // beyond it an observation is an outlier of the result
  int rounds = 3;              // of refining and gating
  int max_iterations = 8;      // a round
  double min_step = 1e-6;      // a step that turns by less and moves by less (of the distance) ends a round
};

struct PoseRefinement {
  Rigid3 cam_from_world;
  std::vector<bool> inlier;  // by observation
  int inliers = 0;
  // Of the twist (rotation, translation) in the camera frame, for unit sigma observations.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  // One standard deviation of the camera centre, world units, as geometry, residuals and experience have it.
  double center_sigma = 0;
};

// None when fewer than four observations remain or the geometry does not fix a pose.
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

// From point-to-image matches of which many may be wrong. None without `min_inliers` that agree.
std::optional<AbsolutePoseResult> AbsolutePose(const CameraModel& camera,
                                               std::span<const PointObservation> observations,
                                               const AbsolutePoseOptions& options = {});

// exp(twist) applied on the left: rotation then translation of the camera frame.
Rigid3 Perturbed(const Rigid3& cam_from_world, const Eigen::Matrix<double, 6, 1>& twist);

}  // namespace ulf::tracking
