// Sets the number of threads of a command's loops (core/base/parallel_for.h).
#pragma once

#include <algorithm>
#include <opencv2/core/utility.hpp>

namespace ulf::commands {

// 0: all processors. More than there are for this process, which taskset limits, TBB would answer with a
// warning.
inline void UseThreads(int threads) {
  if (threads > 0) cv::setNumThreads(std::min(threads, cv::getNumberOfCPUs()));
}

}  // namespace ulf::commands
