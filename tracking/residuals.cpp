#include "tracking/residuals.h"

#include <algorithm>

#include "tracking/absolute_pose.h"

namespace ulf {
namespace {

// A point that cannot be projected (behind the camera): a large constant, so that a step losing points is
// refused.
constexpr double kLostResidual = 100;

}  // namespace

PoseBlock ToBlock(const Rigid3& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  return {q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z()};
}

Rigid3 FromBlock(const double* block) {
  return {Eigen::Quaterniond(block[3], block[0], block[1], block[2]), {block[4], block[5], block[6]}};
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const PoseBlock moved =
      ToBlock(Perturbed(FromBlock(x), Eigen::Map<const Eigen::Matrix<double, 6, 1>>(delta)));
  std::copy(moved.begin(), moved.end(), x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> j(jacobian);
  j.setZero();
  j.topRows<6>().setIdentity();
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Rigid3 to = FromBlock(y), from = FromBlock(x);
  const Eigen::AngleAxisd turn(to.rotation * from.rotation.conjugate());
  Eigen::Map<Eigen::Matrix<double, 6, 1>> twist(y_minus_x);
  twist.head<3>() = turn.angle() * turn.axis();
  twist.tail<3>() = to.translation - turn * from.translation;
  return true;
}

bool PoseManifold::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> j(jacobian);
  j.setZero();
  j.leftCols<6>().setIdentity();
  return true;
}

bool ReprojectionCost::Evaluate(const double* const* parameters, double* residuals,
                                double** jacobians) const {
  const Rigid3 pose = FromBlock(parameters[0]);
  const Eigen::Matrix3d rotation = pose.RotationMatrix();
  const Eigen::Vector3d point =
      rotation * Eigen::Map<const Eigen::Vector3d>(parameters[1]) + pose.translation;
  Eigen::Matrix<double, 2, 3> img_by_point;
  const auto img = camera_.ImgFromCam(point, jacobians ? &img_by_point : nullptr);
  Eigen::Map<Eigen::Vector2d> residual(residuals);
  residual = img ? Eigen::Vector2d((*img - img_) * inverse_sigma_) : Eigen::Vector2d::Constant(kLostResidual);
  if (!jacobians) return true;
  if (!img) img_by_point.setZero();
  img_by_point *= inverse_sigma_;
  if (jacobians[0]) {
    Eigen::Matrix3d minus_cross;
    minus_cross << 0, point.z(), -point.y(), -point.z(), 0, point.x(), point.y(), -point.x(), 0;
    Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> j(jacobians[0]);
    j.leftCols<3>() = img_by_point * minus_cross;
    j.middleCols<3>(3) = img_by_point;
    j.col(6).setZero();
  }
  if (jacobians[1]) {
    Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> j(jacobians[1]);
    j = img_by_point * rotation;
  }
  return true;
}

}  // namespace ulf
