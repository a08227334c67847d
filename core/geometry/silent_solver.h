// Options for Ceres that print nothing: a step that fails is a normal part of the search, and the summary
// reports it.
#pragma once

#include <ceres/solver.h>

namespace ulf {

// The solver uses one thread.
ceres::Solver::Options SilentSolver(int max_iterations);

}  // namespace ulf
