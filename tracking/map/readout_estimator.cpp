#include "tracking/map/readout_estimator.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "core/base/at.h"
#include "core/geometry/small_matrices.h"

namespace ulf::tracking {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Right = Eigen::Matrix<double, 3, 4>;

constexpr int kReadoutMostKeyframes = 24;  // the newest ones with a velocity
constexpr double kReadoutHuberSigmas = 2;

// An observation's weighted part of the least squares problem. Right sides: the residual, and its derivatives
// by the readout, the shear and the stretch.
struct Row {
  int keyframe;
  Eigen::Matrix<double, 2, 6> by_pose;
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Matrix<double, 2, 4> right;
};

std::optional<Row> MakeRow(const CameraModel& camera, const Keyframe& keyframe, const Vector3d& point,
                           const Observation& observation, double huber_sigmas) {
  const Matrix3d rotation = keyframe.cam_from_world.RotationMatrix();
  const Vector3d at_once = rotation * point + keyframe.cam_from_world.translation;
  const Vector2d seen = keyframe.rows ? keyframe.rows->Seen(observation.img, at_once) : observation.img;
  const double share = seen.y() / camera.height - 0.5;
  const double readout_s = keyframe.rows ? keyframe.rows->readout_s() : 0;
  const Vector3d omega = keyframe.velocity->head<3>();
  const Vector3d motion = omega.cross(at_once) + keyframe.velocity->tail<3>();
  const Vector3d in_cam = at_once + readout_s * share * motion;
  Eigen::Matrix<double, 2, 3> img_by_point;
  // Derivatives are taken at the frame's own time: a world that is turned or scaled as a whole turns and
  // scales the velocities with it, and must not look like another readout.
  const auto img = camera.ImgFromCam(in_cam);
  if (!img || !camera.ImgFromCam(at_once, &img_by_point)) return std::nullopt;
  const Vector2d residual = (seen - *img) / observation.sigma_px;
  const double length = residual.norm();
  const double weight = std::sqrt(length <= huber_sigmas ? 1 : huber_sigmas / length);
  Row row;
  const Eigen::Matrix<double, 2, 3> slope = img_by_point * (weight / observation.sigma_px);
  for (int k = 0; k < 2; ++k) {
    const Vector3d move = slope.row(k), turn = at_once.cross(move);
    row.by_pose.row(k) << turn.x(), turn.y(), turn.z(), move.x(), move.y(), move.z();
  }
  row.by_point = slope * rotation;
  row.right.col(0) = weight * residual;
  // The estimate is the whole readout: add back what is compensated already.
  row.right.col(1) = share * (slope * motion);
  row.right.col(0) += readout_s * row.right.col(1);
  const double lens = share * weight / observation.sigma_px;
  row.right.col(2) = Vector2d(lens, 0);
  row.right.col(3) = Vector2d(0, lens);
  return row;
}

// The rows, ordered by point.
struct Problem {
  int keyframes = 0;
  std::vector<Row> rows;
  std::vector<std::size_t> starts;  // of each point, and the end
};

Problem MakeProblem(const CameraModel& camera, const Map& map) {
  Problem problem;
  std::unordered_map<int, int> index;
  // The newest keyframe is left out: its velocity is not known before the next frame.
  for (auto k = map.living().rbegin() + 1;
       k < map.living().rend() && problem.keyframes < kReadoutMostKeyframes; ++k)
    if (map.keyframe(*k).velocity) index[*k] = problem.keyframes++;
  for (const MapPoint& point : map.points()) {
    if (!point.alive) continue;
    const std::size_t start = problem.rows.size();
    for (const Observation& o : point.observations) {
      const auto keyframe = index.find(o.keyframe);
      if (keyframe == index.end()) continue;
      auto row = MakeRow(camera, map.keyframe(o.keyframe), point.position, o, kReadoutHuberSigmas);
      if (!row) continue;
      row->keyframe = keyframe->second;
      problem.rows.push_back(*row);
    }
    if (problem.rows.size() < start + 2)
      problem.rows.resize(start);
    else
      problem.starts.push_back(start);
  }
  problem.starts.push_back(problem.rows.size());
  return problem;
}

// A point's normal equations and their coupling with the poses.
struct PointPart {
  Matrix3d inverse;
  Right right = Right::Zero();
  std::vector<Eigen::Matrix<double, 6, 3>> mixed;  // by row
};

PointPart MakePart(const Problem& problem, std::size_t p) {
  PointPart part;
  Matrix3d normal = Matrix3d::Zero();
  for (std::size_t i = problem.starts[p]; i < problem.starts[p + 1]; ++i) {
    const Row& row = problem.rows[i];
    normal += row.by_point.transpose() * row.by_point;
    part.right += row.by_point.transpose() * row.right;
    part.mixed.emplace_back(row.by_pose.transpose() * row.by_point);
  }
  normal.diagonal() *= 1 + 1e-9;
  part.inverse = normal.inverse();
  return part;
}

// Removes from every right side what poses and points explain (Frisch and Waugh 1933).
bool EliminatePosesAndPoints(Problem& problem) {
  const int size = 6 * problem.keyframes;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(size, 4);
  for (const Row& row : problem.rows) {
    normal.block<6, 6>(6 * row.keyframe, 6 * row.keyframe) += row.by_pose.transpose() * row.by_pose;
    right.block<6, 4>(6 * row.keyframe, 0) += row.by_pose.transpose() * row.right;
  }
  const Eigen::VectorXd diagonal = normal.diagonal();
  const std::size_t points = problem.starts.size() - 1;
  for (std::size_t p = 0; p < points; ++p) {
    const PointPart part = MakePart(problem, p);
    const Row* rows = &problem.rows[problem.starts[p]];
    for (std::size_t a = 0; a < part.mixed.size(); ++a) {
      const Eigen::Matrix<double, 6, 3> by_inverse = part.mixed[a] * part.inverse;
      right.block<6, 4>(6 * rows[a].keyframe, 0) -= by_inverse * part.right;
      for (std::size_t b = 0; b < part.mixed.size(); ++b)
        normal.block<6, 6>(6 * rows[a].keyframe, 6 * rows[b].keyframe) -=
            by_inverse * part.mixed[b].transpose();
    }
  }
  // The observations leave the world's position, orientation and scale free: damping holds them.
  constexpr double kHold = 1e-7;
  normal.diagonal() += kHold * diagonal;
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
  Eigen::MatrixXd poses(size, 4);
  for (int k = 0; k < 4; ++k) poses.col(k) = solver.solve(Eigen::VectorXd(right.col(k)));
  if (!poses.allFinite()) return false;
  for (std::size_t p = 0; p < points; ++p) {
    const PointPart part = MakePart(problem, p);
    Row* rows = &problem.rows[problem.starts[p]];
    Right point = part.right;
    for (std::size_t a = 0; a < part.mixed.size(); ++a)
      point -= part.mixed[a].transpose() * poses.block<6, 4>(6 * rows[a].keyframe, 0);
    point = (part.inverse * point).eval();
    for (std::size_t a = 0; a < part.mixed.size(); ++a)
      rows[a].right -=
          rows[a].by_pose * poses.block<6, 4>(6 * rows[a].keyframe, 0) + rows[a].by_point * point;
  }
  return true;
}

}  // namespace

std::optional<ReadoutEstimate> EstimateReadout(const CameraModel& camera, const Map& map,
                                               int least_keyframes) {
  Problem problem = MakeProblem(camera, map);
  if (problem.keyframes < least_keyframes || !EliminatePosesAndPoints(problem)) return std::nullopt;
  const auto count = At(problem.keyframes);
  std::vector<Matrix3d> normals(count, Matrix3d::Zero());
  std::vector<Vector3d> rights(count, Vector3d::Zero());
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const Row& row : problem.rows) {
    const Eigen::Matrix<double, 2, 3> slopes = row.right.rightCols<3>();
    const Matrix3d square = slopes.transpose() * slopes;
    const Vector3d product = slopes.transpose() * row.right.col(0);
    normals[At(row.keyframe)] += square;
    rights[At(row.keyframe)] += product;
    normal += square;
    right += product;
  }
  const auto invertible = InverseOf(normal);
  if (!invertible) return std::nullopt;
  const Matrix3d& inverse = *invertible;
  const Vector3d found = inverse * right;
  Matrix3d scatter = Matrix3d::Zero();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3d off = rights[k] - normals[k] * found;
    scatter += off * off.transpose();
  }
  const double few = static_cast<double>(count) / static_cast<double>(count - 3);
  const Matrix3d covariance = few * inverse * scatter * inverse;
  return ReadoutEstimate{found.x(), std::sqrt(std::max(0.0, covariance(0, 0))), problem.keyframes};
}

}  // namespace ulf::tracking
