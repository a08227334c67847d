#include "tracking/estimation/two_view_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/at.h"
#include "core/geometry/small_matrices.h"
#include "core/geometry/triangulation.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::tracking {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Returns whether a pair's rays meet behind a camera by more than `noise` of parallax explains.
bool MeetBehind(const Motion& motion, const RayPair& pair, double noise) {
  const Vector3d turned = motion.second_from_first.rotation * pair.first;
  const Vector3d& t = motion.second_from_first.translation;
  const Vector3d across = turned.cross(pair.second);
  if (across.squaredNorm() < noise * noise) return false;
  return pair.second.cross(t).dot(across) < 0 || turned.cross(t).dot(across) < 0;
}

struct MotionStep {
  Eigen::Matrix<double, 5, 5> hessian = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> gradient = Eigen::Matrix<double, 5, 1>::Zero();
};

// Normal equations for a turn and a change of the translation's direction, from the pairs within the gate.
MotionStep LinearizeMotion(const Motion& motion, std::span<const RayPair> pairs, const std::vector<int>& used,
                           double gate, const Vector3d& side, const Vector3d& up) {
  MotionStep equations;
  const Matrix3d rotation = motion.second_from_first.RotationMatrix();
  const Vector3d t = motion.second_from_first.translation;
  for (const int i : used) {
    const RayPair& pair = pairs[At(i)];
    const Vector3d turned = rotation * pair.first;
    const Vector3d line2 = t.cross(turned), line1 = t.cross(pair.second);
    const double scale = 1 / std::sqrt(line2.squaredNorm() + line1.squaredNorm() + 1e-18);
    const double error = pair.second.dot(line2) * scale;
    if (std::abs(error) > gate) continue;
    Eigen::Matrix<double, 5, 1> jacobian;
    // second . (t x (omega x turned)) = omega . (turned x (second x t))
    jacobian.head<3>() = turned.cross(pair.second.cross(t)) * scale;
    const Vector3d by_t = turned.cross(pair.second) * scale;
    jacobian(3) = by_t.dot(side);
    jacobian(4) = by_t.dot(up);
    equations.hessian.noalias() += jacobian * jacobian.transpose();
    equations.gradient.noalias() += error * jacobian;
  }
  return equations;
}

}  // namespace

Matrix3d EssentialFromPose(const Rigid3& second_from_first) {
  return CrossMatrix(second_from_first.translation.normalized()) * second_from_first.RotationMatrix();
}

double EpipolarError(const Matrix3d& essential, const RayPair& pair) {
  const Vector3d line2 = essential * pair.first, line1 = essential.transpose() * pair.second;
  return std::abs(pair.second.dot(line2)) / std::sqrt(line2.squaredNorm() + line1.squaredNorm() + 1e-18);
}

std::optional<Motion> BestMotion(const Matrix3d& essential, std::span<const RayPair> pairs,
                                 const std::vector<int>& used) {
  const SingularValues3 svd = SingularValuesOf(essential);
  Matrix3d u = svd.u, v = svd.v;
  if (u.determinant() < 0) u = -u;
  if (v.determinant() < 0) v = -v;
  Matrix3d w;
  w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  std::optional<Motion> best;
  int most = 0;
  for (const Matrix3d& rotation :
       {Matrix3d(u * w * v.transpose()), Matrix3d(u * w.transpose() * v.transpose())})
    for (const double sign : {1.0, -1.0}) {
      const Rigid3 pose{Eigen::Quaterniond(rotation).normalized(), sign * u.col(2)};
      int in_front = 0;
      for (const int i : used) {
        const RayPair& pair = pairs[At(i)];
        in_front += TriangulatePoint(Rigid3{}, pair.first, pose, pair.second).has_value();
      }
      if (in_front > most) {
        most = in_front;
        best = Motion(pose);
      }
    }
  return best;
}

double TruncatedCost(const Motion& motion, std::span<const RayPair> pairs, const std::vector<int>& used,
                     double gate) {
  double cost = 0;
  for (const int i : used) {
    const double error = EpipolarError(motion.essential, pairs[At(i)]);
    cost += std::min(error * error, gate * gate);
  }
  return cost;
}

double CostInFront(const Motion& motion, std::span<const RayPair> pairs, double gate, double noise) {
  double cost = 0;
  for (const RayPair& pair : pairs) {
    const double error = EpipolarError(motion.essential, pair);
    cost += error < gate && !MeetBehind(motion, pair, noise) ? error * error : gate * gate;
  }
  return cost;
}

Motion RefineMotion(const Motion& initial, std::span<const RayPair> pairs, const std::vector<int>& used,
                    double gate, int iterations) {
  Motion motion = initial;
  double cost = TruncatedCost(motion, pairs, used, gate), damping = 1e-6;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const Vector3d t = motion.second_from_first.translation;
    const Vector3d side = t.unitOrthogonal(), up = t.cross(side);
    const MotionStep equations = LinearizeMotion(motion, pairs, used, gate, side, up);
    motion.direction_sigma =
        std::sqrt(std::max(0.0, (equations.hessian + 1e-12 * MotionStep().hessian.Identity())
                                    .inverse()
                                    .bottomRightCorner<2, 2>()
                                    .trace()));
    bool moved = false;
    double length = 0;
    for (int attempt = 0; attempt < 4 && !moved; ++attempt) {
      Eigen::Matrix<double, 5, 5> damped = equations.hessian;
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += 1e-12;
      const Eigen::Matrix<double, 5, 1> step = -damped.ldlt().solve(equations.gradient);
      if (!step.allFinite()) return motion;
      Eigen::Matrix<double, 6, 1> twist = Eigen::Matrix<double, 6, 1>::Zero();
      twist.head<3>() = step.head<3>();
      const Rigid3 turned = Perturbed({motion.second_from_first.rotation, Vector3d::Zero()}, twist);
      Motion candidate({turned.rotation, (t + step(3) * side + step(4) * up).normalized()});
      const double candidate_cost = TruncatedCost(candidate, pairs, used, gate);
      moved = candidate_cost <= cost;
      if (moved) {
        candidate.direction_sigma = motion.direction_sigma;
        motion = candidate;
        cost = candidate_cost;
        length = step.norm();
      }
      damping = moved ? std::max(1e-9, 0.1 * damping) : std::max(1e-4, 30 * damping);
    }
    if (!moved || length < 1e-8) break;
  }
  return motion;
}

}  // namespace ulf::tracking
