// Tells the processor time of this process, which other programs on the machine disturb less than a clock.
#pragma once

#include <ctime>

namespace ulf {

// Of all threads, user and system.
inline double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

namespace test {
inline double ProcessCpuMs() { return 1e3 * CpuSeconds(); }
}  // namespace test

}  // namespace ulf
