// The cone of rays from one place through a triangle. The columns of `corners` are the triangle's corners
// relative to that place. The inverse of this matrix (up to scale) times a ray gives the barycentric
// coordinates up to scale.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <optional>
#include <vector>

namespace ulf::render {

// Returns the inverse of `corners`, also for badly shaped triangles; zero for one that is seen edge-on.
inline Eigen::Matrix3d ConeFromRay(const Eigen::Matrix3d& corners) {
  constexpr double kLeastVolume = 1e-15;  // share of a right-angled cone's volume: rounding
  const double size = corners.col(0).norm() * corners.col(1).norm() * corners.col(2).norm();
  if (!(std::abs(corners.determinant()) > kLeastVolume * size)) return Eigen::Matrix3d::Zero();
  return corners.inverse();
}

// Returns the barycentric coordinates at which a ray meets the triangle; none if it misses the triangle.
inline std::optional<Eigen::Vector3d> Barycentric(const Eigen::Matrix3d& cone_from_ray,
                                                  const Eigen::Vector3d& ray) {
  // A ray within rounding of an edge belongs to both triangles, so that no ray falls between them.
  constexpr double kEdgeTolerance = 1e-9;
  const Eigen::Vector3d lambda = cone_from_ray * ray;
  const double tolerance = kEdgeTolerance * lambda.cwiseAbs().sum();
  if (!(lambda.minCoeff() >= -tolerance) || tolerance == 0) return std::nullopt;
  const Eigen::Vector3d clamped = lambda.cwiseMax(0.0);
  return clamped / clamped.sum();
}

// Returns false if all rays within `half_angle` (radians) of `axis` lie outside one side of the triangle's
// cone.
inline bool MayMeet(const Eigen::Matrix3d& cone_from_ray, const Eigen::Vector3d& axis, double half_angle) {
  constexpr double kRounding = 1e-9;
  const double limit = -std::sin(half_angle) - kRounding;
  const Eigen::Vector3d sides = cone_from_ray * axis;
  const Eigen::Vector3d sizes = cone_from_ray.rowwise().norm();
  return sizes.x() > 0 && (sides - limit * sizes).minCoeff() >= 0;
}

// Returns the indices of the cones for which MayMeet() is true.
inline std::vector<int> ConesThatMayMeet(const std::vector<Eigen::Matrix3d>& cones_from_ray,
                                         const Eigen::Vector3d& axis, double half_angle) {
  std::vector<int> found;
  for (std::size_t i = 0; i < cones_from_ray.size(); ++i)
    if (MayMeet(cones_from_ray[i], axis, half_angle)) found.push_back(static_cast<int>(i));
  return found;
}

}  // namespace ulf::render
