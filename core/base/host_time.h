// This computer's clocks, in seconds: the wall clock, which stamps frames and events, the steady clock, which
// measures durations, and the CPU time of a thread.
#pragma once

#include <chrono>
#include <ctime>
#include <utility>

namespace ulf {

inline double EpochSeconds() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

inline double SecondsSince(std::chrono::steady_clock::time_point moment) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - moment).count();
}

// Measures the times of laps on this machine's steady clock.
class Stopwatch {
 public:
  // Returns the seconds since the last lap, or since the watch was made.
  double LapSeconds() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Returns the CPU time of the calling thread in seconds, which other programs on the machine do not affect.
inline double ThreadCpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace ulf
