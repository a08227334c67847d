#include "tests/support/host_clock.h"

#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cmath>

namespace ulf::test {
namespace {

std::atomic<long> shift_s{0};

}  // namespace

void ShiftHostClock(double seconds) { shift_s = std::lround(seconds); }

}  // namespace ulf::test

extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const auto result = static_cast<int>(syscall(SYS_clock_gettime, clock, time));
  if (result == 0 && clock == CLOCK_REALTIME) time->tv_sec += ulf::test::shift_s;
  return result;
}
