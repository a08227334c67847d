// Cost functions and manifolds for Ceres: the reprojection error in sigmas, with analytic derivatives.
//
// A pose block holds quaternion (x y z w) and translation of cam_from_world, a point block a world position.
// Derivatives by the pose are by a twist applied on the left in the camera frame: they fill the first six of
// the seven columns, and PoseManifold passes them on unchanged (its PlusJacobian is the identity over a zero
// row). An intrinsics block holds fx fy cx cy and the five coefficients; its manifold says which of them
// move, and keeps the ratio of the focal lengths.
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/free_intrinsics.h"
#include "tracking/estimation/rolling_shutter.h"

namespace ulf::tracking {

using PoseBlock = std::array<double, 7>;
PoseBlock ToBlock(const Rigid3& pose);
Rigid3 FromBlock(const double* block);

// A manifold without Minus(), which Ceres calls only for solvers that are not used here.
class PlusManifold : public ceres::Manifold {
 public:
  bool Minus(const double*, const double*, double*) const override { return false; }
  bool MinusJacobian(const double*, double*) const override { return false; }
};

class PoseManifold final : public PlusManifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
};

using IntrinsicsBlock = std::array<double, 9>;  // fx fy cx cy, coefficients
IntrinsicsBlock ToBlock(const CameraModel& camera);
// Returns the camera of the same size and kind of distortion with these numbers.
CameraModel WithIntrinsics(const CameraModel& camera, const double* block);
// Returns the camera with room for free coefficients: a pinhole becomes radial-tangential with zeros.
CameraModel WithRoomFor(const FreeIntrinsics& free, const CameraModel& camera);

// Returns the free directions as columns over the block: relative focal length, principal point (px), k1, k2.
Eigen::Matrix<double, 9, Eigen::Dynamic> FreeDirections(const CameraModel& camera,
                                                        const FreeIntrinsics& free);

class IntrinsicsManifold final : public PlusManifold {
 public:
  IntrinsicsManifold(const CameraModel& camera, const FreeIntrinsics& free)
      : directions_(FreeDirections(camera, free)) {}
  int AmbientSize() const override { return 9; }
  int TangentSize() const override { return static_cast<int>(directions_.cols()); }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;

 private:
  Eigen::Matrix<double, 9, Eigen::Dynamic> directions_;
};

// Computes the error of a point in a camera. `Blocks`: 7 (pose), 3 (point) and, if free, 9 (intrinsics).
template <int... Blocks>
class ReprojectionError final : public ceres::SizedCostFunction<2, Blocks...> {
 public:
  // `camera` must outlive this. If intrinsics are free, only its size and kind of distortion are used.
  ReprojectionError(const CameraModel& camera, const Eigen::Vector2d& img, double sigma_px)
      : camera_(camera), img_(img), inverse_sigma_(1 / sigma_px) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const CameraModel& camera_;
  Eigen::Vector2d img_;
  double inverse_sigma_;
};
using ReprojectionCost = ReprojectionError<7, 3>;
using IntrinsicsReprojectionCost = ReprojectionError<7, 3, 9>;

// Computes the error of a point in a camera with a rolling shutter. Blocks: pose 7, point 3, velocity 6.
// `time_s` is the RowTime() of the observation.
class RowsReprojectionCost final : public ceres::SizedCostFunction<2, 7, 3, 6> {
 public:
  RowsReprojectionCost(const CameraModel& camera, const Eigen::Vector2d& img, double sigma_px, double time_s)
      : camera_(camera), img_(img), inverse_sigma_(1 / sigma_px), time_s_(time_s) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const CameraModel& camera_;
  Eigen::Vector2d img_;
  double inverse_sigma_, time_s_;
};

// Computes the difference of a velocity from its prior, in standard deviations.
class TwistPriorCost final : public ceres::SizedCostFunction<6, 6> {
 public:
  TwistPriorCost(const Twist& prior, const Twist& sigma)
      : prior_(prior), inverse_sigma_(sigma.cwiseInverse()) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

 private:
  Twist prior_, inverse_sigma_;
};

}  // namespace ulf::tracking
