// Options for Ceres that print nothing: a step that fails is normal in a search; the summary reports it.
#pragma once

#include <ceres/solver.h>

namespace ulf {

// Returns the options, for one thread. Also raises glog's threshold to fatal messages in the whole process.
ceres::Solver::Options SilentSolver(int max_iterations);

}  // namespace ulf
