#include "acquisition/calibration/layout_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/quantile.h"

namespace ulf::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

// Returns the share of the markers seen that are in the largest group joined by such pairs of numbers.
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

// Squares in both directions, the smaller number first: which of them is across cannot be seen.
using SquareCounts = std::pair<int, int>;

// Returns how much darker the places between neighbours are alternately, so many squares beyond an outer row
// of corners; none: one of them lies outside of the picture. `inner`: the row beside it.
std::optional<double> AlternationBeyond(const cv::Mat& picture, const std::vector<cv::Point2f>& outer,
                                        const std::vector<cv::Point2f>& inner, float squares) {
  const cv::Rect2f inside(0, 0, static_cast<float>(picture.cols), static_cast<float>(picture.rows));
  std::array<double, 2> sums = {}, counts = {};
  for (std::size_t i = 0; i + 1 < outer.size(); ++i) {
    const cv::Point2f edge = 0.5F * (outer[i] + outer[i + 1]), before = 0.5F * (inner[i] + inner[i + 1]),
                      place = edge + squares * (edge - before);
    if (!inside.contains(place)) return std::nullopt;
    sums[i % 2] += picture.at<std::uint8_t>(cv::Point(place));
    ++counts[i % 2];
  }
  if (counts[1] == 0) return std::nullopt;
  return std::abs(sums[0] / counts[0] - sums[1] / counts[1]);
}

// Returns whether the board ends on all sides, in the picture: its outermost squares alternate, and what lies
// behind them does not.
bool StandsWhole(const cv::Mat& picture, const cv::Mat& corners, const cv::Size& inner) {
  const auto line = [&](bool is_row, int number) {
    std::vector<cv::Point2f> points;
    for (int i = 0; i < (is_row ? inner.width : inner.height); ++i)
      points.push_back(corners.at<cv::Point2f>(is_row ? number * inner.width + i : i * inner.width + number));
    return points;
  };
  for (const bool is_row : {true, false}) {
    const int last = (is_row ? inner.height : inner.width) - 1;
    for (const auto& [outer, beside] : {std::pair{0, 1}, std::pair{last, last - 1}}) {
      const auto at = line(is_row, outer), before = line(is_row, beside);
      constexpr float kOnSquare = 0.5F, kBehind = 1.25F;  // squares
      const auto on_squares = AlternationBeyond(picture, at, before, kOnSquare),
                 behind = AlternationBeyond(picture, at, before, kBehind);
      constexpr double kMuchLess = 0.5;  // guessed
      if (!on_squares || !behind || *behind > kMuchLess * *on_squares) return false;
    }
  }
  return true;
}

// Returns none when there is no whole board.
std::optional<SquareCounts> CountsIn(const cv::Mat& picture) {
  constexpr double kMostSide_px = 1600;  // larger pictures take seconds
  const double scale = std::min(1.0, kMostSide_px / std::max(picture.cols, picture.rows));
  cv::Mat smaller = picture, corners, which;
  if (scale < 1) cv::resize(picture, smaller, {}, scale, scale, cv::INTER_AREA);
  // From a small beginning the search sometimes ends too early.
  const auto is_found = [&](int least) {
    return cv::findChessboardCornersSB(smaller, {least, least}, corners,
                                       cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_LARGER, which);
  };
  if (!is_found(5) && !is_found(3)) return std::nullopt;
  const cv::Size inner = which.size();
  if (inner.width < 2 || inner.height < 2 || corners.total() != static_cast<std::size_t>(inner.area()) ||
      !StandsWhole(smaller, corners, inner))
    return std::nullopt;
  return std::minmax(inner.width + 1, inner.height + 1);
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

std::optional<cv::Size> OtherChessboardIn(const Board& specified, const std::vector<cv::Mat>& pictures) {
  std::map<SquareCounts, int> times;
  for (const cv::Mat& picture : pictures)
    if (const auto counts = CountsIn(picture)) ++times[*counts];
  const SquareCounts as_said = std::minmax(specified.columns, specified.rows);
  const auto needed = [&](const SquareCounts& counts) {
    const bool is_larger = counts.first >= as_said.first && counts.second >= as_said.second,
               is_near = counts.first <= as_said.first + 1 && counts.second <= as_said.second + 1;
    return is_larger && is_near ? 1 : 2;
  };
  const int seen_as_said = times.contains(as_said) ? times.at(as_said) : 0;
  // A part of a board looks like a smaller one: of all that are seen often enough the largest is meant.
  const SquareCounts* best = nullptr;
  for (const auto& [counts, seen] : times)
    if (counts != as_said && seen >= needed(counts) && seen > seen_as_said &&
        (!best || counts.first * counts.second > best->first * best->second))
      best = &counts;
  if (!best) return std::nullopt;
  const auto [fewer, more] = *best;
  return specified.columns > specified.rows ? cv::Size(more, fewer) : cv::Size(fewer, more);
}

}  // namespace ulf::acquisition
