// What the charts in docs/ say about the chosen solvers, on few seeded samples: another choice, or a solver
// that has become worse, shows here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/charts/solver_grid.h"

namespace ulf::test {
namespace {

TEST(SolverChoice, KneipLosesNoPoseAndHoldsUpEverywhere) {
  for (const Geometry& geometry : kAbsoluteGeometries) {
    EXPECT_LE(RunAlone(geometry, AbsoluteSolver{}, 500, 7).misses, 0.01) << geometry.name;
    for (const double outliers : {0.0, 0.5}) {
      const Outcome outcome =
          RunTrials(geometry, AbsoluteSolver{}, {.outliers = outliers, .count = 10, .seed = 7});
      EXPECT_LE(outcome.failures, 0.1) << geometry.name << ", outliers " << outliers;
    }
  }
}

TEST(SolverChoice, SteweniusLosesHardlyAMotion) {
  for (const Geometry& geometry : kRelativeGeometries)
    EXPECT_LE(RunAlone(geometry, EssentialSolver{}, 200, 7).misses, 0.05) << geometry.name;
}

// What seven and eight points cannot do, and why they are not chosen.
TEST(SolverChoice, APlaneDefeatsSevenAndEightPoints) {
  const Geometry& plane = kRelativeGeometries[1];
  for (const NamedEssentialSolver& other : EssentialSolvers())
    if (other.solver.sample_size == 7 || other.solver.sample_size == 8) {
      EXPECT_GE(RunAlone(plane, other.solver, 100, 7).misses, 0.9) << other.name;
    }
}

TEST(SolverChoice, TwoViewsAreSolvedAtHalfOutliers) {
  for (const Geometry& geometry : kRelativeGeometries)
    if (geometry.relief < 0 && geometry.inliers >= 100 && geometry.farthest < 10) {
      const Outcome outcome =
          RunTrials(geometry, EssentialSolver{}, {.outliers = 0.5, .count = 5, .seed = 7});
      EXPECT_LE(outcome.failures, 0.2) << geometry.name;
    }
}

}  // namespace
}  // namespace ulf::test
