#include "tracking/estimation/residuals.h"

#include <algorithm>

#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/two_view_motion.h"

namespace ulf::tracking {
namespace {

// Residual, sigmas, of a point without projection: so large that the solver refuses steps that lose points.
constexpr double kLostResidual = 100;

bool EvaluateReprojection(const CameraModel& camera, const Eigen::Vector2d& observed, double inverse_sigma,
                          const double* const* parameters, double* residuals, double** jacobians,
                          double* by_intrinsics) {
  const Rigid3 pose = FromBlock(parameters[0]);
  const Eigen::Matrix3d rotation = pose.RotationMatrix();
  const Eigen::Vector3d point =
      rotation * Eigen::Map<const Eigen::Vector3d>(parameters[1]) + pose.translation;
  Eigen::Matrix<double, 2, 3> img_by_point;
  Eigen::Matrix<double, 2, 9> img_by_parameters;
  const auto img = camera.ImgFromCam(point, jacobians ? &img_by_point : nullptr,
                                     by_intrinsics ? &img_by_parameters : nullptr);
  Eigen::Map<Eigen::Vector2d> residual(residuals);
  residual =
      img ? Eigen::Vector2d((*img - observed) * inverse_sigma) : Eigen::Vector2d::Constant(kLostResidual);
  if (!jacobians) return true;
  if (!img) {
    img_by_point.setZero();
    img_by_parameters.setZero();
  }
  img_by_point *= inverse_sigma;
  if (jacobians[0]) {
    Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> j(jacobians[0]);
    j.leftCols<3>() = -img_by_point * CrossMatrix(point);
    j.middleCols<3>(3) = img_by_point;
    j.col(6).setZero();
  }
  if (jacobians[1]) {
    Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> j(jacobians[1]);
    j = img_by_point * rotation;
  }
  if (by_intrinsics) {
    Eigen::Map<Eigen::Matrix<double, 2, 9, Eigen::RowMajor>> j(by_intrinsics);
    j = inverse_sigma * img_by_parameters;
  }
  return true;
}

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

IntrinsicsBlock ToBlock(const CameraModel& camera) {
  IntrinsicsBlock block{camera.fx, camera.fy, camera.cx, camera.cy};
  std::copy(camera.coefficients.begin(), camera.coefficients.end(), block.begin() + 4);
  return block;
}

CameraModel WithIntrinsics(const CameraModel& camera, const double* block) {
  CameraModel moved = camera;
  moved.fx = block[0];
  moved.fy = block[1];
  moved.cx = block[2];
  moved.cy = block[3];
  std::copy(block + 4, block + 9, moved.coefficients.begin());
  return moved;
}

CameraModel WithRoomFor(const FreeIntrinsics& free, const CameraModel& camera) {
  CameraModel roomy = camera;
  if ((free.k1 || free.k2) && camera.distortion == Distortion::kNone) {
    roomy.distortion = Distortion::kRadialTangential;
    roomy.coefficients = {};
  }
  return roomy;
}

Eigen::Matrix<double, 9, Eigen::Dynamic> FreeDirections(const CameraModel& camera,
                                                        const FreeIntrinsics& free) {
  Eigen::Matrix<double, 9, Eigen::Dynamic> directions(9, free.Count());
  directions.setZero();
  int column = 0;
  if (free.focal) {
    directions(0, column) = camera.fx;
    directions(1, column++) = camera.fy;
  }
  if (free.principal_point) {
    directions(2, column++) = 1;
    directions(3, column++) = 1;
  }
  if (free.k1) directions(4, column++) = 1;
  if (free.k2) directions(5, column++) = 1;
  return directions;
}

bool IntrinsicsManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  Eigen::Map<Eigen::Matrix<double, 9, 1>> moved(x_plus_delta);
  moved = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(x) +
          directions_ * Eigen::Map<const Eigen::VectorXd>(delta, directions_.cols());
  return true;
}

bool IntrinsicsManifold::PlusJacobian(const double*, double* jacobian) const {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Map<RowMajor>(jacobian, 9, directions_.cols()) = directions_;
  return true;
}

template <int... Blocks>
bool ReprojectionError<Blocks...>::Evaluate(const double* const* parameters, double* residuals,
                                            double** jacobians) const {
  if constexpr (sizeof...(Blocks) == 2)
    return EvaluateReprojection(camera_, img_, inverse_sigma_, parameters, residuals, jacobians, nullptr);
  else
    return EvaluateReprojection(WithIntrinsics(camera_, parameters[2]), img_, inverse_sigma_, parameters,
                                residuals, jacobians, jacobians ? jacobians[2] : nullptr);
}
bool RowsReprojectionCost::Evaluate(const double* const* parameters, double* residuals,
                                    double** jacobians) const {
  const Rigid3 pose = FromBlock(parameters[0]);
  const Eigen::Matrix3d rotation = pose.RotationMatrix();
  const Eigen::Vector3d at_once =
      rotation * Eigen::Map<const Eigen::Vector3d>(parameters[1]) + pose.translation;
  Eigen::Matrix3d by_point;
  Eigen::Matrix<double, 3, 6> by_twist;
  const Eigen::Vector3d in_cam = PointAfter(Eigen::Map<const Twist>(parameters[2]), at_once, time_s_,
                                            jacobians ? &by_point : nullptr, jacobians ? &by_twist : nullptr);
  Eigen::Matrix<double, 2, 3> img_by_cam;
  const auto img = camera_.ImgFromCam(in_cam, jacobians ? &img_by_cam : nullptr);
  Eigen::Map<Eigen::Vector2d> residual(residuals);
  residual = img ? Eigen::Vector2d((*img - img_) * inverse_sigma_) : Eigen::Vector2d::Constant(kLostResidual);
  if (!jacobians) return true;
  if (!img) img_by_cam.setZero();
  img_by_cam *= inverse_sigma_;
  const Eigen::Matrix<double, 2, 3> img_by_once = img_by_cam * by_point;
  if (jacobians[0]) {
    Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> j(jacobians[0]);
    j.leftCols<3>() = -img_by_once * CrossMatrix(at_once);
    j.middleCols<3>(3) = img_by_once;
    j.col(6).setZero();
  }
  if (jacobians[1])
    Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>{jacobians[1]} = img_by_once * rotation;
  if (jacobians[2])
    Eigen::Map<Eigen::Matrix<double, 2, 6, Eigen::RowMajor>>{jacobians[2]} = img_by_cam * by_twist;
  return true;
}

bool TwistPriorCost::Evaluate(const double* const* parameters, double* residuals, double** jacobians) const {
  Eigen::Map<Twist> residual(residuals);
  residual = (Eigen::Map<const Twist>(parameters[0]) - prior_).cwiseProduct(inverse_sigma_);
  if (jacobians && jacobians[0])
    Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>{jacobians[0]} =
        Eigen::Matrix<double, 6, 6>(inverse_sigma_.asDiagonal());
  return true;
}

template class ReprojectionError<7, 3>;
template class ReprojectionError<7, 3, 9>;

}  // namespace ulf::tracking
