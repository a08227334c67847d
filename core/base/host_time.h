// This computer's two clocks, in seconds: the wall clock, which stamps frames and events, and the steady
// clock, which measures durations.
#pragma once

#include <chrono>

namespace ulf {

inline double EpochSeconds() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

inline double SecondsSince(std::chrono::steady_clock::time_point moment) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - moment).count();
}

}  // namespace ulf
