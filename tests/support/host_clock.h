// This computer's wall clock, set back or forward while a test runs: clock_gettime(CLOCK_REALTIME) of the
// whole process, its libraries included, is this one in the tests that link ulf_host_clock. The steady clock
// goes on as it does on a real computer whose time is set.
#pragma once

namespace ulf::test {

void ShiftHostClock(double seconds);  // beside the true time

}  // namespace ulf::test
