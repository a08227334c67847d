#include "acquisition/simulator/scene/noise.h"

#include <algorithm>
#include <array>

namespace ulf::acquisition {
namespace {

struct Site {
  float x = 0, y = 0, z = 0, distance2 = 1e9f;  // from the query point
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

  // Returns the bisector between the two nearest sites, seen from the origin: (second^2 - first^2) / (2
  // |second - first|).
  Cell Result() const {
    const float dx = second.x - first.x, dy = second.y - first.y, dz = second.z - first.z;
    const float apart = std::sqrt(std::max(1e-12f, dx * dx + dy * dy + dz * dz));
    return {first.hash, std::sqrt(first.distance2), (second.distance2 - first.distance2) / (2 * apart)};
  }
};

// Caches the last look-up for each seed. Textures are painted texel by texel, many to a lattice cell, so that
// the next call nearly always needs the same one.
template <typename Lookup>
class LastLookups {
 public:
  template <typename Make>
  const Lookup& Of(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed, const Make& make) {
    Entry& entry = entries_[seed % entries_.size()];
    if (entry.x != x || entry.y != y || entry.z != z || entry.seed != seed || !entry.made) {
      make(entry.lookup);
      entry.x = x, entry.y = y, entry.z = z, entry.seed = seed, entry.made = true;
    }
    return entry.lookup;
  }

 private:
  struct Entry {
    std::int32_t x = 0, y = 0, z = 0;
    std::uint32_t seed = 0;
    bool made = false;
    Lookup lookup;
  };
  std::array<Entry, 64> entries_;
};

struct Scattered {
  float x, y, z;  // of the site, in lattice units
  std::uint32_t hash;
};

}  // namespace

float ValueNoise(const Eigen::Vector3f& p, std::uint32_t seed) {
  const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const auto ix = static_cast<std::int32_t>(fx), iy = static_cast<std::int32_t>(fy),
             iz = static_cast<std::int32_t>(fz);
  const auto fade = [](float t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const float u = fade(p.x() - fx), v = fade(p.y() - fy), w = fade(p.z() - fz);
  thread_local LastLookups<std::array<float, 8>> last;
  const std::array<float, 8>& corners = last.Of(ix, iy, iz, seed, [&](std::array<float, 8>& made) {
    for (int i = 0; i < 8; ++i)
      made[static_cast<std::size_t>(i)] =
          UnitFloat(HashLattice(ix + (i & 1), iy + (i >> 1 & 1), iz + (i >> 2), seed));
  });
  const auto at = [&](int dx, int dy, int dz) {
    return corners[static_cast<std::size_t>(dx + 2 * dy + 4 * dz)];
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
    q = 2.03f * q + Eigen::Vector3f(13.7f, 5.1f, 9.2f);  // so that lattices of octaves do not coincide
  }
  return sum / total;
}

Cell ScatteredCell2(float x, float y, std::uint32_t seed) {
  const float fx = std::floor(x), fy = std::floor(y);
  const auto ix = static_cast<std::int32_t>(fx), iy = static_cast<std::int32_t>(fy);
  thread_local LastLookups<std::array<Scattered, 9>> last;
  const std::array<Scattered, 9>& sites = last.Of(ix, iy, 0, seed, [&](std::array<Scattered, 9>& made) {
    for (int i = 0; i < 9; ++i) {
      const int dx = i % 3 - 1, dy = i / 3 - 1;
      const std::uint32_t h = HashLattice(ix + dx, iy + dy, 0, seed);
      const std::uint32_t g = h * 0x9E3779B1u;
      made[static_cast<std::size_t>(i)] = {fx + static_cast<float>(dx) + 0.1f + 0.8f * UnitFloat(h),
                                           fy + static_cast<float>(dy) + 0.1f + 0.8f * UnitFloat(g), 0, h};
    }
  });
  Nearest nearest;
  for (const Scattered& site : sites) nearest.Offer(site.x - x, site.y - y, 0, site.hash);
  return nearest.Result();
}

Cell ScatteredCell3(const Eigen::Vector3f& p, std::uint32_t seed) {
  const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const auto ix = static_cast<std::int32_t>(fx), iy = static_cast<std::int32_t>(fy),
             iz = static_cast<std::int32_t>(fz);
  thread_local LastLookups<std::array<Scattered, 27>> last;
  const std::array<Scattered, 27>& sites = last.Of(ix, iy, iz, seed, [&](std::array<Scattered, 27>& made) {
    for (int i = 0; i < 27; ++i) {
      const int dx = i % 3 - 1, dy = i / 3 % 3 - 1, dz = i / 9 - 1;
      const std::uint32_t h = HashLattice(ix + dx, iy + dy, iz + dz, seed);
      const std::uint32_t g = h * 0x9E3779B1u, k = g * 0x85EBCA6Bu;
      made[static_cast<std::size_t>(i)] = {fx + static_cast<float>(dx) + 0.1f + 0.8f * UnitFloat(h),
                                           fy + static_cast<float>(dy) + 0.1f + 0.8f * UnitFloat(g),
                                           fz + static_cast<float>(dz) + 0.1f + 0.8f * UnitFloat(k), h};
    }
  });
  Nearest nearest;
  for (const Scattered& site : sites)
    nearest.Offer(site.x - p.x(), site.y - p.y(), site.z - p.z(), site.hash);
  return nearest.Result();
}

}  // namespace ulf::acquisition
