// Sums of sines with random phases, for the tremor and drift of a simulated hand: smooth, bounded functions
// of time without a visible period.
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
  // `count` sines with frequencies between `low_hz` and `high_hz`; their sum is at most `height`. The same
  // seed and stream give the same waves.
  Waves(std::uint64_t seed, int stream, int count, double low_hz, double high_hz, double height);

  void Add(const Waves& more);
  double At(double time_s) const;
  const std::vector<Wave>& parts() const { return parts_; }

 private:
  std::vector<Wave> parts_;
};

}  // namespace ulf::acquisition
