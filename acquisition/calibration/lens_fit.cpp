#include "acquisition/calibration/lens_fit.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "core/geometry/silent_solver.h"
#include "core/geometry/small_matrices.h"

namespace ulf::acquisition {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Intrinsics as they are estimated: fx, fy / fx, cx, cy and the coefficients.
constexpr int kIntrinsics = 9;
using IntrinsicsBlock = std::array<double, kIntrinsics>;
using PoseBlock = std::array<double, 6>;
using ByIntrinsics = Eigen::Matrix<double, 2, kIntrinsics>;
using ByPose = Eigen::Matrix<double, 2, 6>;

IntrinsicsBlock ToBlock(const CameraModel& camera) {
  IntrinsicsBlock block{camera.fx, camera.fy / camera.fx, camera.cx, camera.cy};
  std::copy(camera.coefficients.begin(), camera.coefficients.end(), block.begin() + 4);
  return block;
}

CameraModel FromBlock(const CameraModel& like, const double* block) {
  CameraModel camera = like;
  camera.fx = block[0];
  camera.fy = block[0] * block[1];
  camera.cx = block[2];
  camera.cy = block[3];
  std::copy(block + 4, block + kIntrinsics, camera.coefficients.begin());
  return camera;
}

PoseBlock ToBlock(const Rigid3& pose) {
  const Eigen::AngleAxisd turn(pose.rotation);
  const Vector3d w = turn.angle() * turn.axis();
  return {w.x(), w.y(), w.z(), pose.translation.x(), pose.translation.y(), pose.translation.z()};
}

Rigid3 PoseFromBlock(const double* block) {
  const Vector3d w(block[0], block[1], block[2]);
  const double angle = w.norm();
  const Vector3d axis = angle > 0 ? Vector3d(w / angle) : Vector3d::UnitX();
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)), {block[3], block[4], block[5]}};
}

Matrix3d Cross(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// R(w + d) = R(w) exp(J d) to first order: the right Jacobian of the rotation group.
Matrix3d RightJacobian(const Vector3d& w) {
  const double angle = w.norm();
  const Matrix3d k = Cross(w);
  if (angle < 1e-6) return Matrix3d::Identity() - 0.5 * k + k * k / 6;
  const double a2 = angle * angle;
  return Matrix3d::Identity() - (1 - std::cos(angle)) / a2 * k +
         (angle - std::sin(angle)) / (a2 * angle) * k * k;
}

struct Projection {
  Vector2d img;
  ByIntrinsics by_intrinsics;
  ByPose by_pose;
};

std::optional<Projection> Project(const CameraModel& camera, const double* pose, const Vector3d& point) {
  const Rigid3 cam_from_board = PoseFromBlock(pose);
  const Matrix3d rotation = cam_from_board.RotationMatrix();
  const Vector3d w(pose[0], pose[1], pose[2]);
  Eigen::Matrix<double, 2, 3> by_point;
  Projection p;
  const auto img =
      camera.ImgFromCam(rotation * point + cam_from_board.translation, &by_point, &p.by_intrinsics);
  if (!img) return std::nullopt;
  p.img = *img;
  // From fx and fy to fx and their ratio.
  p.by_intrinsics.col(0) += p.by_intrinsics.col(1) * (camera.fy / camera.fx);
  p.by_intrinsics.col(1) *= camera.fx;
  p.by_pose.leftCols<3>() = -by_point * rotation * Cross(point) * RightJacobian(w);
  p.by_pose.rightCols<3>() = by_point;
  return p;
}

// The cost of all corners of one view.
class ViewCost final : public ceres::CostFunction {
 public:
  ViewCost(const std::vector<Vector3d>& board_points, const BoardView& view, const CameraModel& like)
      : board_points_(board_points), view_(view), like_(like) {
    set_num_residuals(static_cast<int>(2 * view.ids.size()));
    *mutable_parameter_block_sizes() = {kIntrinsics, 6};
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const CameraModel camera = FromBlock(like_, blocks[0]);
    if (!(camera.fx > 0) || !(camera.fy > 0)) return false;
    for (std::size_t i = 0; i < view_.ids.size(); ++i) {
      const auto p = Project(camera, blocks[1], board_points_[static_cast<std::size_t>(view_.ids[i])]);
      if (!p) return false;
      Eigen::Map<Vector2d>(residuals + 2 * i) = p->img - view_.img[i];
      if (!jacobians) continue;
      if (jacobians[0])
        Eigen::Map<Eigen::Matrix<double, 2, kIntrinsics, Eigen::RowMajor>>(
            jacobians[0] + 2 * i * kIntrinsics) = p->by_intrinsics;
      if (jacobians[1])
        Eigen::Map<Eigen::Matrix<double, 2, 6, Eigen::RowMajor>>(jacobians[1] + 2 * i * 6) = p->by_pose;
    }
    return true;
  }

 private:
  const std::vector<Vector3d>& board_points_;
  const BoardView& view_;
  const CameraModel& like_;
};

// Returns a view for each corner: a robust loss must apply to single corners, because in a block of many a
// bad corner has little weight.
std::vector<BoardView> OneCornerEach(const BoardView& view) {
  std::vector<BoardView> single;
  for (std::size_t i = 0; i < view.ids.size(); ++i)
    single.push_back({view.name, {view.ids[i]}, {view.img[i]}});
  return single;
}

// Returns whether every corner can be projected, which Ceres needs at its start.
bool CanStart(const std::vector<Vector3d>& board_points, const BoardView& view, const CameraModel& camera,
              const PoseBlock& pose) {
  const Rigid3 cam_from_board = PoseFromBlock(pose.data());
  return std::all_of(view.ids.begin(), view.ids.end(), [&](int id) {
    return camera.ImgFromCam(cam_from_board * board_points[static_cast<std::size_t>(id)]).has_value();
  });
}

std::vector<int> FixedParameters(const LensCandidate& candidate) {
  std::vector<int> fixed;
  if (candidate.one_focal) fixed.push_back(1);
  for (int i = 0; i < 5; ++i)
    if (!candidate.estimated[static_cast<std::size_t>(i)]) fixed.push_back(4 + i);
  return fixed;
}

ceres::Solver::Options SolverOptions(int iterations) {
  ceres::Solver::Options solver = SilentSolver(iterations);
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.max_num_consecutive_invalid_steps = 30;
  solver.function_tolerance = 1e-10;
  solver.parameter_tolerance = 1e-10;
  return solver;
}

// Returns the normal matrix of the estimated intrinsics with the poses eliminated, inverted.
std::array<double, kIntrinsics> Sigmas(const std::vector<Vector3d>& board_points,
                                       const std::vector<BoardView>& views, const LensFit& fit) {
  using Normal = Eigen::Matrix<double, kIntrinsics, kIntrinsics>;
  Normal normal = Normal::Zero();
  for (std::size_t v = 0; v < views.size(); ++v) {
    const PoseBlock pose = ToBlock(fit.cam_from_board[v]);
    Eigen::Matrix<double, 6, 6> poses = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, kIntrinsics, 6> mixed = Eigen::Matrix<double, kIntrinsics, 6>::Zero();
    for (const int id : views[v].ids) {
      const auto p = Project(fit.camera, pose.data(), board_points[static_cast<std::size_t>(id)]);
      if (!p) continue;
      normal += p->by_intrinsics.transpose() * p->by_intrinsics;
      mixed += p->by_intrinsics.transpose() * p->by_pose;
      poses += p->by_pose.transpose() * p->by_pose;
    }
    normal -= mixed * poses.ldlt().solve(mixed.transpose());
  }
  std::vector<int> free;
  const std::vector<int> fixed = FixedParameters(fit.candidate);
  for (int i = 0; i < kIntrinsics; ++i)
    if (std::find(fixed.begin(), fixed.end(), i) == fixed.end()) free.push_back(i);
  const auto count = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd reduced(count, count);
  for (Eigen::Index r = 0; r < count; ++r)
    for (Eigen::Index c = 0; c < count; ++c)
      reduced(r, c) = normal(free[static_cast<std::size_t>(r)], free[static_cast<std::size_t>(c)]);
  // Scales to a unit diagonal, because units differ by orders of magnitude.
  const Eigen::VectorXd scale = reduced.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const EigenvaluesX eigen = EigenvaluesOfAnySize(scale.asDiagonal() * reduced * scale.asDiagonal());
  std::array<double, kIntrinsics> sigma{};
  const double freedom = 2.0 * static_cast<double>(fit.corners) - static_cast<double>(count) -
                         6.0 * static_cast<double>(views.size());
  const bool determined = freedom > 0 && eigen.values.minCoeff() > 1e-12;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kIntrinsics, kIntrinsics);
  if (determined) {
    const Eigen::MatrixXd inverse = scale.asDiagonal() * eigen.vectors *
                                    eigen.values.cwiseInverse().asDiagonal() * eigen.vectors.transpose() *
                                    scale.asDiagonal();
    for (Eigen::Index r = 0; r < count; ++r)
      for (Eigen::Index c = 0; c < count; ++c)
        covariance(free[static_cast<std::size_t>(r)], free[static_cast<std::size_t>(c)]) =
            inverse(r, c) * fit.squared_px / freedom;
    // From the ratio back to fy.
    const double ratio = fit.camera.fy / fit.camera.fx, fx = fit.camera.fx;
    const double fy_variance =
        ratio * ratio * covariance(0, 0) + 2 * ratio * fx * covariance(0, 1) + fx * fx * covariance(1, 1);
    covariance(1, 1) = fy_variance;
  }
  for (const int i : free)
    sigma[static_cast<std::size_t>(i)] =
        determined ? std::sqrt(covariance(i, i)) : std::numeric_limits<double>::infinity();
  sigma[1] = determined ? std::sqrt(covariance(1, 1)) : std::numeric_limits<double>::infinity();
  return sigma;
}

constexpr double kNotImagedPx = 1e3;  // residual of a corner that the model cannot project; guessed
constexpr double kLeastRayZ = 0.17;   // of unit rays, about 80 degrees off the axis; guessed
constexpr int kPoseIterations = 30;   // guessed

}  // namespace

int LensCandidate::Parameters() const {
  return (one_focal ? 3 : 4) + static_cast<int>(std::count(estimated.begin(), estimated.end(), true));
}

const std::vector<LensCandidate>& LensCandidates() {
  constexpr Distortion kRadial = Distortion::kRadialTangential, kFish = Distortion::kFisheye;
  static const std::vector<LensCandidate> candidates = {
      {"pinhole, one focal length", Distortion::kNone, true, {}},
      {"pinhole, fx fy", Distortion::kNone, false, {}},
      {"k1, one focal length", kRadial, true, {true}},
      {"k1, fx fy", kRadial, false, {true}},
      {"fisheye k1, one focal length", kFish, true, {true}},
      {"fisheye k1, fx fy", kFish, false, {true}},
      {"k1 k2, one focal length", kRadial, true, {true, true}},
      {"k1 k2, fx fy", kRadial, false, {true, true}},
      {"fisheye k1 k2, one focal length", kFish, true, {true, true}},
      {"fisheye k1 k2, fx fy", kFish, false, {true, true}},
      {"k1 k2 p1 p2, one focal length", kRadial, true, {true, true, true, true}},
      {"k1 k2 p1 p2, fx fy", kRadial, false, {true, true, true, true}},
      {"k1 k2 p1 p2 k3, one focal length", kRadial, true, {true, true, true, true, true}},
      {"k1 k2 p1 p2 k3, fx fy", kRadial, false, {true, true, true, true, true}},
      {"fisheye k1 k2 k3 k4, one focal length", kFish, true, {true, true, true, true}},
      {"fisheye k1 k2 k3 k4, fx fy", kFish, false, {true, true, true, true}},
  };
  return candidates;
}

double LensFit::RmsPx() const { return corners ? std::sqrt(squared_px / static_cast<double>(corners)) : 0; }

std::vector<Vector2d> Residuals(const std::vector<Vector3d>& board_points, const BoardView& view,
                                const CameraModel& camera, const Rigid3& cam_from_board) {
  std::vector<Vector2d> residuals;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const auto img = camera.ImgFromCam(cam_from_board * board_points[static_cast<std::size_t>(view.ids[i])]);
    residuals.push_back(img ? Vector2d(view.img[i] - *img) : Vector2d(kNotImagedPx, kNotImagedPx));
  }
  return residuals;
}

std::optional<Rigid3> PoseOfBoard(const std::vector<Vector3d>& board_points, const BoardView& view,
                                  const CameraModel& camera) {
  // Starts on the normalised plane, where every lens is a pinhole, without corners far off the axis.
  std::vector<cv::Point3f> object;
  std::vector<cv::Point2f> plane;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const auto ray = camera.RayFromImg(view.img[i]);
    if (!ray || ray->z() < kLeastRayZ) continue;
    const Vector3d& point = board_points[static_cast<std::size_t>(view.ids[i])];
    object.emplace_back(static_cast<float>(point.x()), static_cast<float>(point.y()), 0.f);
    plane.emplace_back(static_cast<float>(ray->x() / ray->z()), static_cast<float>(ray->y() / ray->z()));
  }
  if (object.size() < 4) return std::nullopt;
  std::vector<cv::Mat> rotations, translations;
  cv::solvePnPGeneric(object, plane, cv::Matx33d::eye(), cv::noArray(), rotations, translations, false,
                      cv::SOLVEPNP_IPPE);
  std::optional<Rigid3> best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (std::size_t s = 0; s < rotations.size(); ++s) {
    PoseBlock pose;
    for (int k = 0; k < 3; ++k) {
      pose[static_cast<std::size_t>(k)] = rotations[s].at<double>(k);
      pose[static_cast<std::size_t>(3 + k)] = translations[s].at<double>(k);
    }
    if (!std::all_of(pose.begin(), pose.end(), [](double value) { return std::isfinite(value); })) continue;
    if (!CanStart(board_points, view, camera, pose)) continue;
    IntrinsicsBlock intrinsics = ToBlock(camera);
    ceres::Problem problem;
    problem.AddResidualBlock(new ViewCost(board_points, view, camera), nullptr, intrinsics.data(),
                             pose.data());
    problem.SetParameterBlockConstant(intrinsics.data());
    ceres::Solver::Options solver = SolverOptions(kPoseIterations);
    solver.linear_solver_type = ceres::DENSE_QR;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    if (summary.IsSolutionUsable() && summary.final_cost < best_cost) {
      best_cost = summary.final_cost;
      best = PoseFromBlock(pose.data());
    }
  }
  return best;
}

LensFit FitLens(const std::vector<Vector3d>& board_points, const std::vector<BoardView>& views,
                const LensCandidate& candidate, const CameraModel& start, const LensFitOptions& options) {
  LensFit fit{.candidate = candidate};
  fit.camera = start;
  fit.camera.distortion = candidate.distortion;
  if (start.distortion != candidate.distortion) fit.camera.coefficients = {};
  for (std::size_t i = 0; i < 5; ++i)
    if (!candidate.estimated[i]) fit.camera.coefficients[i] = 0;
  if (candidate.one_focal) fit.camera.fx = fit.camera.fy = start.MeanFocalPx();

  IntrinsicsBlock intrinsics = ToBlock(fit.camera);
  std::vector<PoseBlock> poses;
  for (const BoardView& view : views) {
    const auto pose = PoseOfBoard(board_points, view, fit.camera);
    if (!pose) return fit;
    poses.push_back(ToBlock(*pose));
  }
  std::vector<std::vector<BoardView>> blocks;  // the cost functions refer to them
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  ceres::HuberLoss huber(std::max(options.huber_px, 1e-3));
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t v = 0; v < views.size(); ++v) {
    blocks.push_back(options.huber_px > 0 ? OneCornerEach(views[v]) : std::vector<BoardView>{views[v]});
    for (const BoardView& block : blocks.back())
      problem.AddResidualBlock(new ViewCost(board_points, block, fit.camera),
                               options.huber_px > 0 ? &huber : nullptr, intrinsics.data(), poses[v].data());
    ordering->AddElementToGroup(poses[v].data(), 0);
  }
  ordering->AddElementToGroup(intrinsics.data(), 1);
  if (const std::vector<int> fixed = FixedParameters(candidate); !fixed.empty())
    problem.SetManifold(intrinsics.data(), new ceres::SubsetManifold(kIntrinsics, fixed));
  ceres::Solver::Options solver = SolverOptions(options.max_iterations);
  solver.linear_solver_ordering = ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) return fit;

  fit.camera = FromBlock(fit.camera, intrinsics.data());
  if (candidate.one_focal) fit.camera.fy = fit.camera.fx;
  for (const PoseBlock& pose : poses) fit.cam_from_board.push_back(PoseFromBlock(pose.data()));
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const Vector2d& residual : Residuals(board_points, views[v], fit.camera, fit.cam_from_board[v])) {
      fit.squared_px += residual.squaredNorm();
      ++fit.corners;
    }
  fit.usable = std::isfinite(fit.squared_px) && fit.camera.fx > 0;
  if (fit.usable && options.with_sigma) fit.sigma = Sigmas(board_points, views, fit);
  return fit;
}

}  // namespace ulf::acquisition
