// Computes hashes and noise for procedural surfaces: functions of position and seed without a period.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

namespace ulf::acquisition {

// Hashes a 32-bit number (C. Wellons, lowbias32).
inline std::uint32_t Rehash(std::uint32_t h) {
  h ^= h >> 16;
  h *= 0x7FEB352Du;
  h ^= h >> 15;
  h *= 0x846CA68Bu;
  return h ^ h >> 16;
}

// Hashes a lattice point.
inline std::uint32_t HashLattice(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed) {
  return Rehash(static_cast<std::uint32_t>(x) * 0x8DA6B343u ^ static_cast<std::uint32_t>(y) * 0xD8163841u ^
                static_cast<std::uint32_t>(z) * 0xCB1AB31Fu ^ (seed + 1) * 0x9E3779B1u);
}

// Converts a hash to a number from 0 to 1.
inline float UnitFloat(std::uint32_t hash) { return static_cast<float>(hash >> 8) * (1.0f / 16777216.0f); }

// Returns smooth noise, 0 to 1, with one lattice cell per unit.
float ValueNoise(const Eigen::Vector3f& p, std::uint32_t seed);

// Returns a sum of `octaves` of ValueNoise(), each at about twice the frequency and half the height; 0 to 1.
float FractalNoise(const Eigen::Vector3f& p, int octaves, std::uint32_t seed);

// The Voronoi cell that contains a point; each unit cell of the lattice has one random site (Worley noise).
struct Cell {
  std::uint32_t hash = 0;  // of the site
  float to_site = 0;       // distance to it
  float to_border = 0;     // about the distance to the border with the next cell
};
Cell ScatteredCell2(float x, float y, std::uint32_t seed);
Cell ScatteredCell3(const Eigen::Vector3f& p, std::uint32_t seed);

}  // namespace ulf::acquisition
