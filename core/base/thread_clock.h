// CPU time of the calling thread, in seconds: independent of other programs on the machine.
#pragma once

#include <ctime>

namespace ulf {

inline double ThreadCpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace ulf
