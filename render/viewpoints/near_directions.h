// Finds the directions near a given one in a k-d tree (Bentley 1975), so that ten thousand viewpoints are not
// compared with each other pair by pair.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <queue>
#include <vector>

namespace ulf::render {

class NearDirections {
 public:
  // Takes unit vectors, which must outlive the tree.
  explicit NearDirections(const std::vector<Eigen::Vector3d>& directions)
      : directions_(directions), order_(directions.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    Split(0, order_.size());
  }

  // Calls `see(index)` for each direction whose chord to `direction` (the distance of the two unit vectors)
  // is at most `chord`, in no order.
  template <typename See>
  void Within(const Eigen::Vector3d& direction, double chord, const See& see) const {
    Search(
        direction, 0, order_.size(), [chord] { return chord * chord; },
        [&](std::size_t index, double) { see(index); });
  }

  // Returns the chord to the `rank`-th nearest direction, counted from 1; a direction of the tree is its own
  // nearest. Infinite if there are fewer directions.
  double ChordOfNearest(const Eigen::Vector3d& direction, std::size_t rank) const {
    std::priority_queue<double> nearest;
    const auto most = [&] {
      return nearest.size() < rank ? std::numeric_limits<double>::infinity() : nearest.top();
    };
    Search(direction, 0, order_.size(), most, [&](std::size_t, double squared) {
      nearest.push(squared);
      if (nearest.size() > rank) nearest.pop();
    });
    return std::sqrt(most());
  }

 private:
  // Returns the widest axis of a part of the order, which the middle of the part divides.
  int AxisOf(std::size_t begin, std::size_t end) const {
    Eigen::AlignedBox3d box;
    for (std::size_t i = begin; i < end; ++i) box.extend(directions_[order_[i]]);
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    return axis;
  }
  void Split(std::size_t begin, std::size_t end) {
    if (axes_.empty()) axes_.resize(order_.size());
    if (end - begin < 2) return;
    const int axis = AxisOf(begin, end);
    const std::size_t middle = (begin + end) / 2;
    std::nth_element(order_.begin() + static_cast<std::ptrdiff_t>(begin),
                     order_.begin() + static_cast<std::ptrdiff_t>(middle),
                     order_.begin() + static_cast<std::ptrdiff_t>(end), [&](std::size_t a, std::size_t b) {
                       return directions_[a](axis) < directions_[b](axis);
                     });
    axes_[middle] = axis;
    Split(begin, middle);
    Split(middle + 1, end);
  }
  // `most` returns the squared chord that limits the search.
  template <typename Most, typename See>
  void Search(const Eigen::Vector3d& direction, std::size_t begin, std::size_t end, const Most& most,
              const See& see) const {
    if (begin >= end) return;
    const std::size_t middle = (begin + end) / 2, index = order_[middle];
    if (const double squared = (directions_[index] - direction).squaredNorm(); squared <= most())
      see(index, squared);
    if (end - begin < 2) return;
    const double off = direction(axes_[middle]) - directions_[index](axes_[middle]);
    const bool first_is_near = off < 0;
    Search(direction, first_is_near ? begin : middle + 1, first_is_near ? middle : end, most, see);
    if (off * off <= most())
      Search(direction, first_is_near ? middle + 1 : begin, first_is_near ? end : middle, most, see);
  }

  const std::vector<Eigen::Vector3d>& directions_;
  std::vector<std::size_t> order_;
  std::vector<int> axes_;  // by place in the order: along which axis the direction there divides its part
};

}  // namespace ulf::render
