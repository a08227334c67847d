// What Eigen works out of small matrices, compiled once: a file that names one of its decompositions takes
// seconds longer to compile, and each size again.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace ulf {

// matrix = u values.asDiagonal() v^T, the largest value first.
struct SingularValues3 {
  Eigen::Matrix3d u;
  Eigen::Vector3d values;
  Eigen::Matrix3d v;
};
SingularValues3 SingularValuesOf(const Eigen::Matrix3d& matrix);

// Of a symmetric matrix: the smallest eigenvalue first, eigenvectors in columns of length one.
struct Eigenvalues3 {
  Eigen::Vector3d values;
  Eigen::Matrix3d vectors;
};
Eigenvalues3 EigenvaluesOf(const Eigen::Matrix3d& symmetric);

// Of the smallest eigenvalue of a symmetric matrix of any size.
Eigen::VectorXd SmallestEigenvector(const Eigen::MatrixXd& symmetric);

// Nothing where the matrix is singular to the precision of its numbers.
std::optional<Eigen::Matrix3d> InverseOf(const Eigen::Matrix3d& matrix);

// x of normal x = right, for a symmetric matrix without negative eigenvalues. Not finite where there is none.
Eigen::Vector3d SolveNormal(const Eigen::Matrix3d& normal, const Eigen::Vector3d& right);
Eigen::Matrix<double, 6, 1> SolveNormal(const Eigen::Matrix<double, 6, 6>& normal,
                                        const Eigen::Matrix<double, 6, 1>& right);

// The smallest turn that takes one direction to another.
Eigen::Quaterniond TurnBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace ulf
