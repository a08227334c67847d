#include "acquisition/calibration/chessboard_count.h"

#include <algorithm>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace ulf::acquisition {
namespace {

// Squares in both directions, the smaller number first: which of them is across cannot be seen.
using SquareCounts = std::pair<int, int>;

// Whether there is room for another corner beyond the outermost ones, and for what makes it one: else the board may go on
// outside of the picture.
bool StandsWhole(const cv::Mat& corners, const cv::Size& inner, const cv::Size& picture) {
  const auto at = [&](int column, int row) { return corners.at<cv::Point2f>(row * inner.width + column); };
  const cv::Rect2f inside(0, 0, static_cast<float>(picture.width), static_cast<float>(picture.height));
  const auto beyond = [&](const cv::Point2f& last, const cv::Point2f& before) {
    return inside.contains(last + 1.5F * (last - before));
  };
  for (int column = 0; column < inner.width; ++column)
    if (!beyond(at(column, 0), at(column, 1)) ||
        !beyond(at(column, inner.height - 1), at(column, inner.height - 2)))
      return false;
  for (int row = 0; row < inner.height; ++row)
    if (!beyond(at(0, row), at(1, row)) || !beyond(at(inner.width - 1, row), at(inner.width - 2, row)))
      return false;
  return true;
}

// None: there is no whole board.
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
      !StandsWhole(corners, inner, smaller.size()))
    return std::nullopt;
  return std::minmax(inner.width + 1, inner.height + 1);
}

}  // namespace

std::optional<cv::Size> OtherChessboardIn(const Board& said, const std::vector<cv::Mat>& pictures) {
  std::map<SquareCounts, int> times;
  for (const cv::Mat& picture : pictures)
    if (const auto counts = CountsIn(picture)) ++times[*counts];
  const SquareCounts as_said = std::minmax(said.columns, said.rows);
  const auto needed = [&](const SquareCounts& counts) {
    const bool is_larger = counts.first >= as_said.first && counts.second >= as_said.second,
               is_near = counts.first <= as_said.first + 1 && counts.second <= as_said.second + 1;
    return is_larger && is_near ? 1 : is_larger ? 2 : 3;
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
  return said.columns > said.rows ? cv::Size(more, fewer) : cv::Size(fewer, more);
}

}  // namespace ulf::acquisition
