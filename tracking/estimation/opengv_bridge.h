// Wraps OpenGV's minimal solvers: no other source includes OpenGV, whose poses are camera-to-world and whose
// relative poses take the second frame to the first; these functions return cam_from_world, and essential
// matrices that take the first view to the second. sampling.h draws the samples; docs/measured/tracking.md,
// "Which solvers, and why", says why these. Rays are unit vectors in the camera frame.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

// Returns up to four poses cam_from_world from the first three points (Kneip, Scaramuzza and Siegwart 2011).
std::vector<Rigid3> SolveP3p(std::span<const Eigen::Vector3d> points_in_world,
                             std::span<const Eigen::Vector3d> rays_in_camera);

// Returns up to ten essential matrices E with second^T E first = 0 from the first five pairs of rays
// (Stewenius, Engels and Nister 2006).
std::vector<Eigen::Matrix3d> SolveFivePoint(std::span<const Eigen::Vector3d> rays_in_first,
                                            std::span<const Eigen::Vector3d> rays_in_second);

}  // namespace ulf::tracking
