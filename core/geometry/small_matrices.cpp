#include "core/geometry/small_matrices.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace ulf {

using Eigen::Matrix3d;
using Eigen::Vector3d;

SingularValues3 SingularValuesOf(const Matrix3d& matrix) {
  const Eigen::JacobiSVD<Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Eigenvalues3 EigenvaluesOf(const Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

EigenvaluesX EigenvaluesOfAnySize(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

std::optional<Matrix3d> InverseOf(const Matrix3d& matrix) {
  const Eigen::FullPivLU<Matrix3d> lu(matrix);
  if (!lu.isInvertible()) return std::nullopt;
  return Matrix3d(lu.inverse());
}

Vector3d SolveNormal(const Matrix3d& normal, const Vector3d& right) { return normal.ldlt().solve(right); }

Eigen::Matrix<double, 6, 1> SolveNormal(const Eigen::Matrix<double, 6, 6>& normal,
                                        const Eigen::Matrix<double, 6, 1>& right) {
  return normal.ldlt().solve(right);
}

Eigen::Quaterniond TurnBetween(const Vector3d& from, const Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

}  // namespace ulf
