// OpenGV's solvers side by side, for the charts that choose among them; the product has only the chosen ones
// (tracking/estimation/opengv_bridge.h, whose conventions these share).
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/rigid3.h"
#include "tests/support/floors.h"
#include "tracking/estimation/opengv_bridge.h"

namespace ulf::test {

// From a sample's points, and the rays to them, to poses.
struct AbsoluteSolver {
  int sample_size = 3;
  std::vector<Rigid3> (*solve)(std::span<const Eigen::Vector3d> points_in_world,
                               std::span<const Eigen::Vector3d> rays_in_camera) = SolveP3p;
};
struct NamedAbsoluteSolver {
  std::string name;
  AbsoluteSolver solver;
};
// The product's first.
std::vector<NamedAbsoluteSolver> AbsoluteSolvers();

// From a sample's rays to essential matrices E with second^T E first = 0.
struct EssentialSolver {
  int sample_size = 5;
  std::vector<Eigen::Matrix3d> (*solve)(std::span<const Eigen::Vector3d> rays_in_first,
                                        std::span<const Eigen::Vector3d> rays_in_second) = SolveFivePoint;
};
struct NamedEssentialSolver {
  std::string name;
  EssentialSolver solver;
};
std::vector<NamedEssentialSolver> EssentialSolvers();

}  // namespace ulf::test
