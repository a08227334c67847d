// Sums of sines with random phases: smooth, bounded, without a period that anyone would notice, and a
// function of time. What makes a simulated hand tremble and drift.
#pragma once

#include <cstdint>
#include <vector>

namespace ulf::acquisition {

class Waves {
 public:
  struct Wave {
    double height, frequency_hz, phase;
  };

  Waves() = default;
  // `count` of them with frequencies spread over low to high; `height` is the most that their sum can be. The
  // same seed and stream give the same waves.
  Waves(std::uint64_t seed, int stream, int count, double low_hz, double high_hz, double height);

  void Add(const Waves& more);
  double At(double time_s) const;
  const std::vector<Wave>& parts() const { return parts_; }

 private:
  std::vector<Wave> parts_;
};

}  // namespace ulf::acquisition
