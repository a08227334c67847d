#include "core/geometry/triangulation.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "core/geometry/angles.h"

namespace ulf {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::optional<Vector3d> TriangulatePoint(const Rigid3& first_from_world, const Vector3d& ray_in_first,
                                         const Rigid3& second_from_world, const Vector3d& ray_in_second) {
  const Vector3d center1 = first_from_world.OriginInSource(), center2 = second_from_world.OriginInSource();
  const Vector3d ray1 = first_from_world.DirectionInSource(ray_in_first);
  const Vector3d ray2 = second_from_world.DirectionInSource(ray_in_second);
  const Vector3d baseline = center2 - center1;
  const Vector3d p = ray1.cross(ray2), q = ray1.cross(baseline), r = ray2.cross(baseline);
  const double p_norm = p.norm(), q_norm = q.norm(), r_norm = r.norm();
  constexpr double kParallel = 1e-9;
  if (p_norm < kParallel || q_norm + r_norm < kParallel * baseline.norm()) return std::nullopt;
  // Depths along the rays from the law of sines; both must be in front, which their cross products tell.
  if (p.dot(r) >= 0 || p.dot(q) >= 0) return std::nullopt;
  const double depth1 = r_norm / p_norm, depth2 = q_norm / p_norm;
  const Vector3d on1 = center1 + depth1 * ray1, on2 = center2 + depth2 * ray2;
  return Vector3d((q_norm * on1 + r_norm * on2) / (q_norm + r_norm));
}

std::optional<Vector3d> TriangulatePoint(std::span<const RayObservation> observations) {
  if (observations.size() < 2) return std::nullopt;
  std::optional<Vector3d> point;
  // First with equal weights (distance from each ray), then with angles: distance divided by depth.
  for (int round = 0; round < 3; ++round) {
    Matrix3d normal = Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    for (const RayObservation& seen : observations) {
      const Vector3d center = seen.cam_from_world.OriginInSource();
      const Vector3d ray = seen.cam_from_world.DirectionInSource(seen.ray_in_cam);
      const double depth = point ? (*point - center).norm() : 1;
      const Matrix3d across = (Matrix3d::Identity() - ray * ray.transpose()) / (depth * depth);
      normal += across;
      right += across * center;
    }
    const Eigen::LDLT<Matrix3d> solver(normal);
    if (solver.info() != Eigen::Success || solver.rcond() < 1e-12) return std::nullopt;
    point = solver.solve(right);
    if (!point->allFinite()) return std::nullopt;
  }
  for (const RayObservation& seen : observations)
    if ((seen.cam_from_world * *point).dot(seen.ray_in_cam) <= 0) return std::nullopt;
  return point;
}

double ParallaxAngle(const Vector3d& point_in_world, const Vector3d& first_center,
                     const Vector3d& second_center) {
  return AngleBetween(first_center - point_in_world, second_center - point_in_world);
}

}  // namespace ulf
