// The rays from one place through a triangle. Corners are columns, taken from that place; the inverse of
// their matrix, which may be scaled, times a ray gives the barycentric coordinates up to scale.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <optional>

namespace ulf::render {

// Of badly shaped triangles, too; zero for those that are seen edge-on.
inline Eigen::Matrix3d ConeFromRay(const Eigen::Matrix3d& corners) {
  const double size = corners.col(0).norm() * corners.col(1).norm() * corners.col(2).norm();
  if (!(std::abs(corners.determinant()) > 1e-15 * size)) return Eigen::Matrix3d::Zero();
  return corners.inverse();
}

inline std::optional<Eigen::Vector3d> Barycentric(const Eigen::Matrix3d& cone_from_ray,
                                                  const Eigen::Vector3d& ray) {
  // A ray within rounding of an edge belongs to both triangles; none may be lost between them.
  constexpr double kEdgeTolerance = 1e-9;
  const Eigen::Vector3d lambda = cone_from_ray * ray;
  const double tolerance = kEdgeTolerance * lambda.cwiseAbs().sum();
  if (!(lambda.minCoeff() >= -tolerance) || tolerance == 0) return std::nullopt;
  const Eigen::Vector3d clamped = lambda.cwiseMax(0.0);
  return clamped / clamped.sum();
}

// Whether rays within `half_angle` of `axis` may meet the triangle: not when one side of its cone has all of
// them on its outer side.
inline bool MayMeet(const Eigen::Matrix3d& cone_from_ray, const Eigen::Vector3d& axis, double half_angle) {
  const double limit = -std::sin(half_angle) - 1e-9;
  const Eigen::Vector3d sides = cone_from_ray * axis;
  const Eigen::Vector3d sizes = cone_from_ray.rowwise().norm();
  return sizes.x() > 0 && (sides - limit * sizes).minCoeff() >= 0;
}

}  // namespace ulf::render
