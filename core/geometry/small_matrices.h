// Decompositions of small matrices, here because each use of Eigen's templates costs seconds of compiling.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace ulf {

// matrix = u values.asDiagonal() v^T; the singular values descend.
struct SingularValues3 {
  Eigen::Matrix3d u;
  Eigen::Vector3d values;
  Eigen::Matrix3d v;
};
SingularValues3 SingularValuesOf(const Eigen::Matrix3d& matrix);

// Eigenvalues of a symmetric matrix in ascending order; the eigenvectors are columns of length one.
struct Eigenvalues3 {
  Eigen::Vector3d values;
  Eigen::Matrix3d vectors;
};
Eigenvalues3 EigenvaluesOf(const Eigen::Matrix3d& symmetric);

// The same for a symmetric matrix of any size.
struct EigenvaluesX {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
EigenvaluesX EigenvaluesOfAnySize(const Eigen::MatrixXd& symmetric);

// Returns the inverse; none if the matrix is singular to the precision of its numbers.
std::optional<Eigen::Matrix3d> InverseOf(const Eigen::Matrix3d& matrix);

// Solves normal * x = right for a positive semidefinite matrix. Without a solution, x may not be finite.
Eigen::Vector3d SolveNormal(const Eigen::Matrix3d& normal, const Eigen::Vector3d& right);
Eigen::Matrix<double, 6, 1> SolveNormal(const Eigen::Matrix<double, 6, 6>& normal,
                                        const Eigen::Matrix<double, 6, 1>& right);

// Returns the smallest rotation that takes one direction to another.
Eigen::Quaterniond TurnBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace ulf
