// Ceres without words on the operator's terminal: a step that fails is told in the summary, and belongs to
// the search.
#pragma once

#include <ceres/solver.h>

namespace ulf {

// One thread.
ceres::Solver::Options SilentSolver(int max_iterations);

}  // namespace ulf
