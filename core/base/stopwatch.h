// Times of laps on this machine's steady clock.
#pragma once

#include <chrono>
#include <utility>

namespace ulf {

class Stopwatch {
 public:
  // Since the last lap, or since the watch was made.
  double LapSeconds() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace ulf
