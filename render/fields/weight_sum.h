// Sums of sparse weights.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/at.h"
#include "render/fields/loop_subdivision.h"

namespace ulf::render {

class WeightSum {
 public:
  void Add(int vertex, double weight) {
    if (At(vertex) >= sum_.size()) {
      sum_.resize(At(vertex) + 1, 0.0);
      is_listed_.resize(At(vertex) + 1, 0);
    }
    if (!std::exchange(is_listed_[At(vertex)], std::uint8_t{1})) listed_.push_back(vertex);
    sum_[At(vertex)] += weight;
  }
  void Add(const SparseWeights& weights, double factor) {
    for (const auto& [vertex, weight] : weights) Add(vertex, factor * weight);
  }
  // The sum, in ascending order of vertices; the next sum begins.
  SparseWeights Take() {
    std::ranges::sort(listed_);
    SparseWeights taken;
    taken.reserve(listed_.size());
    for (const int vertex : listed_) {
      taken.emplace_back(vertex, std::exchange(sum_[At(vertex)], 0.0));
      is_listed_[At(vertex)] = 0;
    }
    listed_.clear();
    return taken;
  }

 private:
  std::vector<double> sum_;  // of each vertex, so that adding takes no search
  std::vector<std::uint8_t> is_listed_;
  std::vector<int> listed_;
};

}  // namespace ulf::render
