#include "acquisition/simulator/waves.h"

#include <cmath>
#include <random>

namespace ulf::acquisition {

Waves::Waves(std::uint64_t seed, int stream, int count, double low_hz, double high_hz, double height) {
  std::mt19937_64 random(seed * 1000003u + static_cast<std::uint64_t>(stream));
  const auto uniform = [&random] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  for (int i = 0; i < count; ++i) {
    const double share = (i + uniform()) / count;
    parts_.push_back({height / count, low_hz * std::pow(high_hz / low_hz, share), 2 * M_PI * uniform()});
  }
}

void Waves::Add(const Waves& more) { parts_.insert(parts_.end(), more.parts_.begin(), more.parts_.end()); }

double Waves::At(double time_s) const {
  double sum = 0;
  for (const Wave& wave : parts_)
    sum += wave.height * std::sin(2 * M_PI * wave.frequency_hz * time_s + wave.phase);
  return sum;
}

}  // namespace ulf::acquisition
