#include "acquisition/calibration/layout_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/quantile.h"

namespace ulf::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

// The share of the markers seen that are in the largest group joined by such pairs of numbers.
double LargestGroupShare(const Neighbours& neighbours, const std::vector<std::pair<int, int>>& joined) {
  std::map<int, int> parents;
  const auto root = [&](int number) {
    while (true) {
      const int parent = parents.try_emplace(number, number).first->second;
      if (parent == number) return number;
      number = parent;
    }
  };
  for (const auto& [from, to] : joined) parents[root(from)] = root(to);
  std::map<int, int> seen;
  int largest = 0, all = 0;
  for (const auto& [number, times] : neighbours.times) {
    all += times;
    if (parents.contains(number)) largest = std::max(largest, seen[root(number)] += times);
  }
  return all > 0 ? static_cast<double>(largest) / all : 0;
}

}  // namespace

Neighbours NeighboursIn(const std::vector<SeenMarkers>& pictures) {
  constexpr std::size_t kNearest = 4;
  Neighbours all;
  for (const SeenMarkers& seen : pictures)
    for (const auto& [from, a] : seen) {
      std::vector<MarkerPair> around;
      for (const auto& [to, b] : seen)
        if (to != from)
          around.push_back({from, to, 0.25 * (a[1] - a[0] + a[2] - a[3] + b[1] - b[0] + b[2] - b[3]),
                            0.25 * (a[3] - a[0] + a[2] - a[1] + b[3] - b[0] + b[2] - b[1]),
                            0.25 * (b[0] + b[1] + b[2] + b[3] - a[0] - a[1] - a[2] - a[3])});
      if (around.empty()) continue;
      ++all.times[from];
      const std::size_t count = std::min(kNearest, around.size());
      std::partial_sort(
          around.begin(), around.begin() + static_cast<std::ptrdiff_t>(count), around.end(),
          [](const MarkerPair& x, const MarkerPair& y) { return x.shift.norm() < y.shift.norm(); });
      around.resize(count);
      for (MarkerPair& pair : around) {
        if (pair.from > pair.to) {
          std::swap(pair.from, pair.to);
          pair.shift = -pair.shift;
        }
        all.pairs.push_back(pair);
      }
    }
  std::ranges::stable_sort(all.pairs, {}, [](const MarkerPair& p) { return std::pair(p.from, p.to); });
  return all;
}

LayoutFit LayoutFitOf(const Board& layout, const Neighbours& neighbours) {
  const std::vector<Vector2i> places = layout.MarkerPlaces();
  const auto count = static_cast<int>(places.size());
  std::vector<double> steps;
  struct Expected {
    const MarkerPair* pair;
    Vector2d along;
  };
  std::vector<Expected> known;
  for (const MarkerPair& pair : neighbours.pairs) {
    const int from = pair.from - layout.first_marker, to = pair.to - layout.first_marker;
    if (from < 0 || to >= count) continue;
    const Vector2i by = places[static_cast<std::size_t>(to)] - places[static_cast<std::size_t>(from)];
    const Vector2d along = by.x() * pair.right + by.y() * pair.down;
    if (along.squaredNorm() <= 0) continue;
    known.push_back({&pair, along});
    steps.push_back(along.dot(pair.shift) / along.squaredNorm());
  }
  if (steps.empty()) return {};
  LayoutFit fit;
  fit.step = Median(steps);
  // The tags of an AprilGrid may stand on their heads (board.h); those of other boards do not.
  if (layout.kind == BoardKind::kAprilGrid ? std::abs(fit.step) <= 1 : fit.step <= 1) return {};
  constexpr double kNear = 0.2;  // of the way to the neighbour: perspective and lens bend less. Guessed.
  std::vector<std::pair<int, int>> joined;
  for (std::size_t begin = 0, end = 0; begin < known.size(); begin = end) {
    const MarkerPair& first = *known[begin].pair;
    std::size_t near = 0;
    for (; end < known.size() && known[end].pair->from == first.from && known[end].pair->to == first.to;
         ++end)
      if ((known[end].pair->shift - fit.step * known[end].along).norm() <
          kNear * known[end].pair->shift.norm())
        ++near;
    if (2 * near > end - begin) joined.emplace_back(first.from, first.to);
  }
  fit.step = std::abs(fit.step);
  fit.share = LargestGroupShare(neighbours, joined);
  return fit;
}

}  // namespace ulf::acquisition
