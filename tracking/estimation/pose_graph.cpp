#include "tracking/estimation/pose_graph.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/at.h"
#include "core/geometry/silent_solver.h"
#include "tracking/estimation/residuals.h"
#include "tracking/estimation/two_view_motion.h"

namespace ulf::tracking {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

constexpr int kPoseGraphMaxIterations = 30;

// Quaternion (x y z w), translation, logarithm of the scale.
using Block = std::array<double, 8>;

Block ToBlock(const Similarity3& pose) {
  const Eigen::Quaterniond q(pose.rotation);
  const Vector3d& t = pose.translation;
  return {q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z(), std::log(pose.scale)};
}

Similarity3 SimilarityOf(const double* block) {
  return {std::exp(block[7]),
          Eigen::Quaterniond(block[3], block[0], block[1], block[2]).normalized().toRotationMatrix(),
          {block[4], block[5], block[6]}};
}

Vector3d RotationVector(const Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

// Returns the rotation vector's derivative by a small rotation on the right; transposed, on the left.
Matrix3d InverseRightJacobian(const Vector3d& turn) {
  const double angle = turn.norm();
  const Matrix3d cross = CrossMatrix(turn);
  const double factor =
      angle < 1e-4 ? 1.0 / 12 : 1 / (angle * angle) - (1 + std::cos(angle)) / (2 * angle * std::sin(angle));
  return Matrix3d::Identity() + 0.5 * cross + factor * cross * cross;
}

class SimilarityManifold final : public PlusManifold {
 public:
  explicit SimilarityManifold(bool rigid) : tangent_(rigid ? 6 : 7) {}
  int AmbientSize() const override { return 8; }
  int TangentSize() const override { return tangent_; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    Vector7d motion = Vector7d::Zero();
    std::copy_n(delta, tangent_, motion.data());
    const Block moved = ToBlock(Perturbed(SimilarityOf(x), motion));
    std::copy(moved.begin(), moved.end(), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> j(jacobian, 8,
                                                                                         tangent_);
    j.setIdentity();
    return true;
  }

 private:
  int tangent_;
};

class EdgeCost final : public ceres::SizedCostFunction<7, 8, 8> {
 public:
  EdgeCost(const PoseGraphEdge& edge, double unit) : edge_(edge), unit_(unit) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    Matrix7d by_from, by_to;
    const bool derive = jacobians != nullptr;
    const double root = std::sqrt(edge_.weight);
    Eigen::Map<Vector7d> error(residuals);
    error = root * PoseGraphError(edge_, SimilarityOf(parameters[0]), SimilarityOf(parameters[1]), unit_,
                                  derive ? &by_from : nullptr, derive ? &by_to : nullptr);
    for (int block = 0; derive && block < 2; ++block) {
      if (!jacobians[block]) continue;
      Eigen::Map<Eigen::Matrix<double, 7, 8, Eigen::RowMajor>> j(jacobians[block]);
      j.setZero();
      j.leftCols<7>() = root * (block == 0 ? by_from : by_to);
    }
    return true;
  }

 private:
  PoseGraphEdge edge_;
  double unit_;
};

}  // namespace

Vector7d PoseGraphError(const PoseGraphEdge& edge, const Similarity3& from, const Similarity3& to,
                        double unit, Matrix7d* by_from, Matrix7d* by_to) {
  const Similarity3& measured = edge.to_from_from;
  const Similarity3 difference = measured.Inverse() * to * from.Inverse();
  const Vector3d turn = RotationVector(difference.rotation);
  Vector7d error;
  for (int i = 0; i < 3; ++i) {
    error(i) = turn(i);
    error(3 + i) = difference.translation(i) / unit;
  }
  error(6) = std::log(difference.scale);
  const Matrix3d right = InverseRightJacobian(turn);
  if (by_from) {  // difference * motion^-1
    by_from->setZero();
    by_from->topLeftCorner<3, 3>() = -right;
    by_from->block<3, 3>(3, 3) = -difference.scale / unit * difference.rotation;
    (*by_from)(6, 6) = -1;
  }
  if (by_to) {  // (measured^-1 * motion * measured) * difference
    const Matrix3d back = measured.rotation.transpose();
    const Vector3d& shift = measured.translation;
    by_to->setZero();
    by_to->topLeftCorner<3, 3>() = right.transpose() * back;
    by_to->block<3, 3>(3, 0) =
        (-CrossMatrix(difference.translation) * back - back * CrossMatrix(shift) / measured.scale) / unit;
    by_to->block<3, 3>(3, 3) = back / (measured.scale * unit);
    by_to->block<3, 1>(3, 6) = (difference.translation + back * shift / measured.scale) / unit;
    (*by_to)(6, 6) = 1;
  }
  return error;
}

PoseGraphSummary OptimizePoseGraph(PoseGraph& graph, const PoseGraphOptions& options) {
  std::vector<Block> blocks;
  for (const Similarity3& pose : graph.cam_from_world) blocks.push_back(ToBlock(pose));
  ceres::Problem::Options ownership;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  SimilarityManifold manifold(options.rigid);
  ceres::Problem problem(ownership);
  for (Block& block : blocks) problem.AddParameterBlock(block.data(), 8, &manifold);
  bool any_fixed = false;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    if (i < graph.fixed.size() && graph.fixed[i]) {
      problem.SetParameterBlockConstant(blocks[i].data());
      any_fixed = true;
    }
  if (!any_fixed && !blocks.empty()) problem.SetParameterBlockConstant(blocks.front().data());
  for (const PoseGraphEdge& edge : graph.edges)
    problem.AddResidualBlock(new EdgeCost(edge, options.unit), nullptr, blocks[At(edge.from)].data(),
                             blocks[At(edge.to)].data());
  ceres::Solver::Options solver = SilentSolver(kPoseGraphMaxIterations);
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  ceres::Solver::Summary solved;
  ceres::Solve(solver, &problem, &solved);
  const PoseGraphSummary summary{solved.IsSolutionUsable(), solved.initial_cost, solved.final_cost};
  if (!summary.usable) return summary;
  for (std::size_t i = 0; i < blocks.size(); ++i) graph.cam_from_world[i] = SimilarityOf(blocks[i].data());
  return summary;
}

}  // namespace ulf::tracking
