// Wraps OpenGV, for all other code. OpenGV's poses are camera-to-world and its relative poses take the second
// frame to the first; this bridge returns cam_from_world and second_from_first. It has only the solvers that
// charts chose (docs/measured/tracking.md, "Which solvers, and why"); sampling.h samples. All directions are
// unit vectors in the camera frame.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

// Returns up to four poses from three points (Kneip, Scaramuzza and Siegwart 2011).
std::vector<Rigid3> SolveP3p(std::span<const Eigen::Vector3d> points_in_world,
                             std::span<const Eigen::Vector3d> rays_in_camera);

// Returns essential matrices E with second^T E first = 0 from exactly five pairs of rays (Stewenius, Engels
// and Nister 2006).
std::vector<Eigen::Matrix3d> SolveFivePoint(std::span<const Eigen::Vector3d> rays_in_first,
                                            std::span<const Eigen::Vector3d> rays_in_second);

}  // namespace ulf::tracking
