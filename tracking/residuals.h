// The reprojection error for Ceres, with analytic derivatives.
//
// A pose block holds quaternion (x y z w) and translation of cam_from_world, a point block a world position.
// Derivatives by the pose are by a twist applied on the left in the camera frame: they fill the first six of
// the seven columns, and PoseManifold passes them on unchanged (its PlusJacobian is the identity over a zero
// row).
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>

#include "acquisition/camera_model.h"
#include "acquisition/rigid3.h"

namespace ulf {

using PoseBlock = std::array<double, 7>;
PoseBlock ToBlock(const Rigid3& pose);
Rigid3 FromBlock(const double* block);

class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

class ReprojectionCost final : public ceres::SizedCostFunction<2, 7, 3> {
 public:
  // `camera` must outlive this.
  ReprojectionCost(const CameraModel& camera, const Eigen::Vector2d& img, double sigma_px)
      : camera_(camera), img_(img), inverse_sigma_(1 / sigma_px) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const CameraModel& camera_;
  Eigen::Vector2d img_;
  double inverse_sigma_;
};

}  // namespace ulf
