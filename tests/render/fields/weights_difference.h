// How far two weights of a vertex are apart, for the tests of subdivision.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>

#include "render/fields/loop_subdivision.h"

namespace ulf::test {

// Of the weights of any one view.
inline double LargestDifference(const render::SparseWeights& a, const render::SparseWeights& b) {
  std::map<int, double> difference;
  for (const auto& [of, weight] : a) difference[of] += weight;
  for (const auto& [of, weight] : b) difference[of] -= weight;
  double most = 0;
  for (const auto& [of, weight] : difference) most = std::max(most, std::abs(weight));
  return most;
}

}  // namespace ulf::test
