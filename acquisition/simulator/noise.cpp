#include "acquisition/simulator/noise.h"

#include <algorithm>

namespace ulf {
namespace {

struct Site {
  float x = 0, y = 0, z = 0, distance2 = 1e9f;  // from the point asked about
  std::uint32_t hash = 0;
};

struct Nearest {
  Site first, second;

  void Offer(float x, float y, float z, std::uint32_t hash) {
    const float distance2 = x * x + y * y + z * z;
    if (distance2 >= second.distance2) return;
    if (distance2 < first.distance2) {
      second = first;
      first = {x, y, z, distance2, hash};
    } else {
      second = {x, y, z, distance2, hash};
    }
  }

  // The bisector between the two nearest sites, seen from the origin: (second^2 - first^2) / (2 |second -
  // first|).
  Cell Result() const {
    const float dx = second.x - first.x, dy = second.y - first.y, dz = second.z - first.z;
    const float apart = std::sqrt(std::max(1e-12f, dx * dx + dy * dy + dz * dz));
    return {first.hash, std::sqrt(first.distance2), (second.distance2 - first.distance2) / (2 * apart)};
  }
};

}  // namespace

float ValueNoise(const Eigen::Vector3f& p, std::uint32_t seed) {
  const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const auto ix = static_cast<std::int32_t>(fx), iy = static_cast<std::int32_t>(fy),
             iz = static_cast<std::int32_t>(fz);
  const auto fade = [](float t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const float u = fade(p.x() - fx), v = fade(p.y() - fy), w = fade(p.z() - fz);
  const auto at = [&](int dx, int dy, int dz) {
    return UnitFloat(HashLattice(ix + dx, iy + dy, iz + dz, seed));
  };
  const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
  const float low = mix(mix(at(0, 0, 0), at(1, 0, 0), u), mix(at(0, 1, 0), at(1, 1, 0), u), v);
  const float high = mix(mix(at(0, 0, 1), at(1, 0, 1), u), mix(at(0, 1, 1), at(1, 1, 1), u), v);
  return mix(low, high, w);
}

float FractalNoise(const Eigen::Vector3f& p, int octaves, std::uint32_t seed) {
  float sum = 0, height = 1, total = 0;
  Eigen::Vector3f q = p;
  for (int i = 0; i < octaves; ++i) {
    sum += height * ValueNoise(q, seed + static_cast<std::uint32_t>(i) * 101u);
    total += height;
    height *= 0.5f;
    q = 2.03f * q + Eigen::Vector3f(13.7f, 5.1f, 9.2f);  // off the lattice of the octave before
  }
  return sum / total;
}

Cell ScatteredCell2(float x, float y, std::uint32_t seed) {
  const float fx = std::floor(x), fy = std::floor(y);
  const auto ix = static_cast<std::int32_t>(fx), iy = static_cast<std::int32_t>(fy);
  Nearest nearest;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const std::uint32_t h = HashLattice(ix + dx, iy + dy, 0, seed);
      const std::uint32_t g = h * 0x9E3779B1u;
      nearest.Offer(fx + static_cast<float>(dx) + 0.1f + 0.8f * UnitFloat(h) - x,
                    fy + static_cast<float>(dy) + 0.1f + 0.8f * UnitFloat(g) - y, 0, h);
    }
  return nearest.Result();
}

Cell ScatteredCell3(const Eigen::Vector3f& p, std::uint32_t seed) {
  const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const auto ix = static_cast<std::int32_t>(fx), iy = static_cast<std::int32_t>(fy),
             iz = static_cast<std::int32_t>(fz);
  Nearest nearest;
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const std::uint32_t h = HashLattice(ix + dx, iy + dy, iz + dz, seed);
        const std::uint32_t g = h * 0x9E3779B1u, k = g * 0x85EBCA6Bu;
        nearest.Offer(fx + static_cast<float>(dx) + 0.1f + 0.8f * UnitFloat(h) - p.x(),
                      fy + static_cast<float>(dy) + 0.1f + 0.8f * UnitFloat(g) - p.y(),
                      fz + static_cast<float>(dz) + 0.1f + 0.8f * UnitFloat(k) - p.z(), h);
      }
  return nearest.Result();
}

}  // namespace ulf
