#include "tracking/estimation/bundle_uncertainty.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/at.h"
#include "core/geometry/small_matrices.h"
#include "tracking/estimation/two_view_motion.h"

// Solves column by column and uses lazy products: Eigen's blocked products of large matrices need memory
// aligned for AVX, which EIGEN_MAX_ALIGN_BYTES (cmake/house.cmake) does not promise.
namespace ulf::tracking {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix63d = Eigen::Matrix<double, 6, 3>;

// An observation's part of the normal equations; the camera's unknown is a twist of its frame.
struct Share {
  int block = -1;  // of the camera; -1: it is fixed
  Matrix63d camera_by_point = Matrix63d::Zero();
};

struct NormalMatrix {
  MatrixXd cameras;                  // points eliminated, 6 rows a free camera that is seen
  std::vector<int> block_of_camera;  // -1: fixed or without observations
  std::vector<bool> seen;            // by camera
  int observations = 0, points = 0;  // that count
  double squared_sigmas = 0;         // of their errors
};

void AddPoint(const std::vector<CameraModel>& lenses, const BundleProblem& problem, std::size_t point,
              const std::vector<const BundleObservation*>& observations, NormalMatrix& normal) {
  const bool known = point < problem.known.size() && problem.known[point];
  if (observations.size() < 2 && !known) return;  // no constraint on the cameras
  Matrix3d of_point = Matrix3d::Zero();
  std::vector<Share> shares;
  for (const BundleObservation* seen : observations) {
    const auto c = At(seen->camera);
    const Rigid3& pose = problem.cam_from_world[c];
    const Vector3d in_cam = pose * problem.points[point];
    Eigen::Matrix<double, 2, 3> img_by_point;
    const auto img = lenses[problem.lens.empty() ? 0 : At(problem.lens[c])].ImgFromCam(in_cam, &img_by_point);
    if (!img) continue;
    img_by_point /= seen->sigma_px;
    Eigen::Matrix<double, 2, 6> by_camera;
    by_camera << -img_by_point * CrossMatrix(in_cam), img_by_point;
    const Eigen::Matrix<double, 2, 3> by_point = img_by_point * pose.RotationMatrix();
    ++normal.observations;
    normal.squared_sigmas += (*img - seen->img).squaredNorm() / (seen->sigma_px * seen->sigma_px);
    of_point += by_point.transpose() * by_point;
    const int block = normal.block_of_camera[c];
    if (block < 0) continue;
    normal.cameras.block<6, 6>(6 * block, 6 * block) += by_camera.transpose() * by_camera;
    shares.push_back({block, by_camera.transpose() * by_point});
  }
  if (known) return;
  ++normal.points;
  const auto inverse = InverseOf(of_point);
  if (!inverse) return;
  for (const Share& a : shares) {
    const Matrix63d left = a.camera_by_point * *inverse;
    for (const Share& b : shares)
      normal.cameras.block<6, 6>(6 * a.block, 6 * b.block) -= left * b.camera_by_point.transpose();
  }
}

NormalMatrix MakeNormalMatrix(const std::vector<CameraModel>& lenses, const BundleProblem& problem,
                              const std::vector<bool>& fixed) {
  NormalMatrix normal;
  std::vector<std::vector<const BundleObservation*>> by_point(problem.points.size());
  normal.seen.assign(problem.cam_from_world.size(), false);
  for (const BundleObservation& seen : problem.observations) {
    if (seen.outlier) continue;
    by_point[At(seen.point)].push_back(&seen);
    normal.seen[At(seen.camera)] = true;
  }
  int blocks = 0;
  for (std::size_t c = 0; c < problem.cam_from_world.size(); ++c)
    normal.block_of_camera.push_back(normal.seen[c] && !fixed[c] ? blocks++ : -1);
  normal.cameras = MatrixXd::Zero(6 * blocks, 6 * blocks);
  for (std::size_t p = 0; p < by_point.size(); ++p) AddPoint(lenses, problem, p, by_point[p], normal);
  return normal;
}

// Describes how the cameras' twists change when the world is moved, or turned and scaled about their middle.
struct GaugeMotions {
  MatrixXd by;        // seven columns
  double extent = 0;  // of the centres
};

GaugeMotions MotionsOf(const BundleProblem& problem, const NormalMatrix& normal) {
  Vector3d middle = Vector3d::Zero();
  int count = 0;
  for (std::size_t c = 0; c < problem.cam_from_world.size(); ++c)
    if (normal.block_of_camera[c] >= 0) {
      middle += problem.cam_from_world[c].OriginInSource();
      ++count;
    }
  middle /= std::max(1, count);
  GaugeMotions motions{MatrixXd::Zero(normal.cameras.rows(), 7), 0};
  for (std::size_t c = 0; c < problem.cam_from_world.size(); ++c) {
    const int row = 6 * normal.block_of_camera[c];
    if (row < 0) continue;
    const Matrix3d rotation = problem.cam_from_world[c].RotationMatrix();
    const Vector3d center = problem.cam_from_world[c].OriginInSource() - middle;
    motions.by.block<3, 3>(row + 3, 0) = -rotation;
    motions.by.block<3, 3>(row, 3) = -rotation;
    motions.by.block<3, 3>(row + 3, 3) = rotation * CrossMatrix(center);
    motions.by.block<3, 1>(row + 3, 6) = -rotation * center;
    motions.extent = std::max(motions.extent, center.norm());
  }
  return motions;
}

// Returns orthonormal columns that span the same space (Gram-Schmidt, twice for accuracy).
MatrixXd BasisOf(MatrixXd columns) {
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    for (int round = 0; round < 2; ++round)
      for (Eigen::Index other = 0; other < c; ++other)
        columns.col(c) -= columns.col(other).dot(columns.col(c)) * columns.col(other);
    const double length = columns.col(c).norm();
    if (length > 0) columns.col(c) /= length;
  }
  return columns;
}

// Removes the gauge from a change of the cameras: aligns the world so that the centres fit best. Turns weigh
// just enough to determine the turn about a line that all cameras lie on.
class WithoutGauge {
 public:
  explicit WithoutGauge(const GaugeMotions& motions) : motions_(motions.by), weighed_(motions.by) {
    constexpr double kTurnsWeigh = 1e-3;  // of the centres
    for (Eigen::Index row = 0; row < weighed_.rows(); ++row)
      if (row % 6 < 3) weighed_.row(row) *= std::pow(kTurnsWeigh * motions.extent, 2);
    solver_.compute(weighed_.transpose().lazyProduct(motions_));
  }
  // Returns a row of the projection.
  Eigen::VectorXd Row(Eigen::Index row) const {
    const Eigen::VectorXd moved = motions_.row(row).transpose();
    Eigen::VectorXd projected = -(weighed_ * solver_.transpose().solve(moved));
    projected[row] += 1;
    return projected;
  }

 private:
  MatrixXd motions_, weighed_;
  Eigen::FullPivLU<Eigen::Matrix<double, 7, 7>> solver_;
};

}  // namespace

std::vector<double> CenterSigmas(const std::vector<CameraModel>& lenses, const BundleProblem& problem) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  std::vector<bool> fixed = problem.fixed;
  fixed.resize(problem.cam_from_world.size(), false);
  const bool gauge_is_free =
      std::count(fixed.begin(), fixed.end(), true) < 2 &&
      std::find(problem.known.begin(), problem.known.end(), true) == problem.known.end();
  if (gauge_is_free) std::fill(fixed.begin(), fixed.end(), false);
  const NormalMatrix normal = MakeNormalMatrix(lenses, problem, fixed);
  std::vector<double> sigmas;
  for (std::size_t c = 0; c < fixed.size(); ++c)
    sigmas.push_back(fixed[c] ? 0 : normal.seen[c] ? kInfinite : std::numeric_limits<double>::quiet_NaN());
  const auto size = normal.cameras.rows();
  const long spare = 2L * normal.observations - 3L * normal.points - size + (gauge_is_free ? 7 : 0);
  if (size == 0 || spare <= 0 || !(normal.cameras.diagonal().minCoeff() > 0)) return sigmas;

  // Turns and shifts have different units: scale each unknown to unit variance.
  const Eigen::VectorXd unit = normal.cameras.diagonal().cwiseSqrt().cwiseInverse();
  MatrixXd scaled = unit.asDiagonal() * normal.cameras * unit.asDiagonal();
  GaugeMotions motions;
  if (gauge_is_free) {
    motions = MotionsOf(problem, normal);
    const MatrixXd basis = BasisOf(unit.cwiseInverse().asDiagonal() * motions.by);
    scaled += basis.lazyProduct(basis.transpose());
  }
  const Eigen::LDLT<MatrixXd> solver(scaled);
  constexpr double kLeastPivot = 1e-9;  // a smaller one is rounding: something can move freely
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > kLeastPivot)) return sigmas;
  std::optional<WithoutGauge> without_gauge;
  if (gauge_is_free) without_gauge.emplace(motions);
  const double variance = normal.squared_sigmas / static_cast<double>(spare);
  for (std::size_t c = 0; c < sigmas.size(); ++c) {
    const int first = 6 * normal.block_of_camera[c];
    if (first < 0) continue;
    double sum = 0;
    for (Eigen::Index row = first + 3; row < first + 6; ++row) {
      const Eigen::VectorXd of_center =
          without_gauge ? without_gauge->Row(row) : Eigen::VectorXd(Eigen::VectorXd::Unit(size, row));
      const Eigen::VectorXd right = unit.cwiseProduct(of_center);
      sum += right.dot(solver.solve(right));
    }
    sigmas[c] = std::sqrt(variance * std::max(0.0, sum));
  }
  return sigmas;
}

}  // namespace ulf::tracking
