// Sets this computer's wall clock back or forward for one process: in the tests that link ulf_host_clock,
// clock_gettime(CLOCK_REALTIME) of the whole process, its libraries included, is shifted. The steady clock
// goes on as it does on a real computer whose time is set.
#pragma once

namespace ulf::test {

void ShiftHostClock(double seconds);  // ahead of the true time; replaces an earlier shift

}  // namespace ulf::test
