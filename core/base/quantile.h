// Order statistics of a list of numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace ulf {

// Returns the value below which `share` (0 to 1) of the values lie, by nearest rank: one of the values, the
// upper one if two are equally near. Returns 0 for no values.
inline double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto at = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

inline double Median(std::vector<double> values) { return Quantile(std::move(values), 0.5); }

}  // namespace ulf
