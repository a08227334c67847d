// Where a person without guidance goes next who sees the painted sphere: rows over the cap, at a spacing that
// they guess from the discs on it, with an error of their own and one of each row, then the nearest hole that
// they can see.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "acquisition/simulator/waves.h"
#include "coverage/coverage_map.h"

namespace ulf {

class RowsByEye {
 public:
  RowsByEye(std::uint64_t seed, bool novice);
  // The direction to go to from `hand`; none when nothing looks unpainted. `map` has views.
  std::optional<Eigen::Vector3d> Toward(const CoverageMap& map, const Eigen::Vector3d& hand, double time_s);

 private:
  struct Hole {
    Eigen::Vector3d direction;
    double seen_s = 0;
  };
  double Spread(double sigma);
  std::optional<Eigen::Vector3d> FindHole(const CoverageMap& map, const Eigen::Vector3d& hand, double size);

  std::mt19937_64 random_;
  const bool novice_;
  const double own_spacing_;  // of rows, disc radii
  const Waves wobble_;        // of a row's height, disc radii
  int upwards_ = 0;           // 0: not begun
  int heading_ = 1;
  double level_ = 0;
  bool rows_done_ = false;
  std::optional<Hole> hole_;
  std::vector<Hole> given_up_;
};

}  // namespace ulf
