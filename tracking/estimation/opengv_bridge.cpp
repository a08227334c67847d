#include "tracking/estimation/opengv_bridge.h"

#include <optional>

#include <opengv/types.hpp>

#include <opengv/absolute_pose/CentralAbsoluteAdapter.hpp>
#include <opengv/absolute_pose/methods.hpp>
#include <opengv/relative_pose/CentralRelativeAdapter.hpp>
#include <opengv/relative_pose/methods.hpp>

namespace ulf::tracking {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

opengv::points_t Points(std::span<const Vector3d> points) { return {points.begin(), points.end()}; }
opengv::bearingVectors_t Rays(std::span<const Vector3d> rays) { return {rays.begin(), rays.end()}; }

// OpenGV's [R | c] takes camera to world.
std::optional<Rigid3> CamFromWorld(const opengv::transformation_t& world_from_cam) {
  if (!world_from_cam.allFinite()) return std::nullopt;
  const Matrix3d rotation = world_from_cam.leftCols<3>();
  if (std::abs(rotation.determinant() - 1) > 1e-3) return std::nullopt;
  const Rigid3 pose{Eigen::Quaterniond(rotation).normalized(), world_from_cam.col(3)};
  return pose.Inverse();
}

}  // namespace

std::vector<Rigid3> SolveP3p(std::span<const Vector3d> points_in_world,
                             std::span<const Vector3d> rays_in_camera) {
  const auto points = Points(points_in_world.first(3));
  const auto rays = Rays(rays_in_camera.first(3));
  opengv::absolute_pose::CentralAbsoluteAdapter adapter(rays, points);
  std::vector<Rigid3> poses;
  for (const auto& solution : opengv::absolute_pose::p3p_kneip(adapter))
    if (const auto pose = CamFromWorld(solution)) poses.push_back(*pose);
  return poses;
}

std::vector<Matrix3d> SolveFivePoint(std::span<const Vector3d> rays_in_first,
                                     std::span<const Vector3d> rays_in_second) {
  const auto first = Rays(rays_in_first.first(5));
  const auto second = Rays(rays_in_second.first(5));
  opengv::relative_pose::CentralRelativeAdapter adapter(first, second);
  std::vector<Matrix3d> essentials;
  // Stewenius' eigenvalue form: Nister's root bracketing, as implemented there, loses a solution now and then
  // (docs/measured/charts/two_view_solvers.png).
  for (const auto& solution : opengv::relative_pose::fivept_stewenius(adapter)) {
    const Matrix3d real = solution.real();
    if (!real.allFinite() || solution.imag().norm() > 1e-6 * real.norm()) continue;
    essentials.emplace_back(real.transpose());  // its E is first^T E second = 0
  }
  return essentials;
}

}  // namespace ulf::tracking
