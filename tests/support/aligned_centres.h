// Measures how far camera centres are from the truth.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "core/geometry/rigid3.h"
#include "core/geometry/similarity3.h"

namespace ulf::test {

// Returns the root mean square distance of the centres of `found` from those of `truth`, in the truth's unit,
// after the similarity that fits best; not a number where none does.
inline double AlignedCentreError(const std::vector<Rigid3>& found, const std::vector<Rigid3>& truth) {
  std::vector<Eigen::Vector3d> centres, true_centres;
  for (const Rigid3& cam_from_world : found) centres.push_back(cam_from_world.OriginInSource());
  for (const Rigid3& cam_from_world : truth) true_centres.push_back(cam_from_world.OriginInSource());
  const auto aligned = AlignPoints(centres, true_centres);
  if (!aligned) return std::numeric_limits<double>::quiet_NaN();
  double squared = 0;
  for (std::size_t i = 0; i < centres.size(); ++i)
    squared += (*aligned * centres[i] - true_centres[i]).squaredNorm();
  return std::sqrt(squared / static_cast<double>(centres.size()));
}

}  // namespace ulf::test
