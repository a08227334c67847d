#include "core/geometry/silent_solver.h"

#include <glog/logging.h>

namespace ulf {

ceres::Solver::Options SilentSolver(int max_iterations) {
  FLAGS_minloglevel = google::GLOG_FATAL;
  ceres::Solver::Options solver;
  solver.max_num_iterations = max_iterations;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  return solver;
}

}  // namespace ulf
