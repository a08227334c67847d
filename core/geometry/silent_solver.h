// Options for Ceres that print nothing: a step that fails belongs to the search and is reported in the
// summary.
#pragma once

#include <ceres/solver.h>

namespace ulf {

// With one thread.
ceres::Solver::Options SilentSolver(int max_iterations);

}  // namespace ulf
