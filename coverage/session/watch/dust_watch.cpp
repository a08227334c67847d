#include "coverage/session/watch/dust_watch.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ulf::coverage {
namespace {

// Logarithm of the light against that around: of spots from one to three hundredths of the width.
cv::Mat SpotContrast(const cv::Mat& log_light) {
  const double width = log_light.cols;
  const auto odd = [](double px) { return 2 * static_cast<int>(0.5 * px) + 1; };
  const int spot = odd(0.008 * width), around = odd(0.05 * width);
  cv::Mat near, far;
  cv::blur(log_light, near, {spot, spot});
  cv::blur(log_light, far, {around, around});
  constexpr float kMost = 0.5f;  // the scene's own edges count for no more
  return cv::min(cv::max(near - far, -kMost), kMost);
}

}  // namespace

void DustWatch::LookAt(const cv::Rect& cell, const cv::Mat& contrast) {
  const cv::Mat part = contrast(cell);
  sum_(cell) += part;
  cv::accumulateSquare(part, sum2_(cell));
}

void DustWatch::After(const PicturePair& pair) {
  const cv::Size size = pair.log_light.size();
  if (sum_.size() != size) {
    sum_ = cv::Mat::zeros(size, CV_32F);
    sum2_ = cv::Mat::zeros(size, CV_32F);
    looks_.assign(kColumns * kRows, 0);
    moved_.assign(kColumns * kRows, {});
    spots_.clear();
  }
  // Of the points in each cell and around it; where there is none, of all.
  std::vector<cv::Point2f> motion(kColumns * kRows);
  std::vector<int> points(kColumns * kRows);
  for (const PictureTrack& track : pair.tracks) {
    const int column = static_cast<int>(track.now.x * kColumns / static_cast<float>(size.width)),
              row = static_cast<int>(track.now.y * kRows / static_cast<float>(size.height));
    for (int y = std::max(0, row - 1); y <= std::min(kRows - 1, row + 1); ++y)
      for (int x = std::max(0, column - 1); x <= std::min(kColumns - 1, column + 1); ++x) {
        motion[static_cast<std::size_t>(y * kColumns + x)] += track.now - track.before;
        ++points[static_cast<std::size_t>(y * kColumns + x)];
      }
  }
  cv::Mat contrast;
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const auto cell = static_cast<std::size_t>(row * kColumns + column);
      moved_[cell] += points[cell] > 0 ? motion[cell] / static_cast<float>(points[cell]) : pair.motion;
      if (std::hypot(moved_[cell].x, moved_[cell].y) < options_.moved * size.width) continue;
      if (contrast.empty()) contrast = SpotContrast(pair.log_light);
      const cv::Point from(column * size.width / kColumns, row * size.height / kRows),
          to((column + 1) * size.width / kColumns, (row + 1) * size.height / kRows);
      LookAt({from, to}, contrast);
      ++looks_[cell];
      moved_[cell] = {};
    }
  if (pair.now_s - looked_s_ < options_.every_s && pair.now_s >= looked_s_) return;
  looked_s_ = pair.now_s;
  LookForSpots();
}

void DustWatch::LookForSpots() {
  spots_.clear();
  const cv::Size size = sum_.size();
  cv::Mat mean = cv::Mat::zeros(size, CV_32F), sigma = cv::Mat::ones(size, CV_32F);
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const int looks = looks_[static_cast<std::size_t>(row * kColumns + column)];
      if (looks < options_.fewest_looks) continue;
      const cv::Rect cell({column * size.width / kColumns, row * size.height / kRows},
                          cv::Point((column + 1) * size.width / kColumns, (row + 1) * size.height / kRows));
      cv::Mat cell_mean = sum_(cell) / looks, variance = sum2_(cell) / looks - cell_mean.mul(cell_mean);
      cell_mean.copyTo(mean(cell));
      constexpr double kNoise = 1e-5;
      cv::sqrt(cv::max(variance, kNoise) / looks, sigma(cell));
    }
  const int reach = std::max(2, static_cast<int>(0.02 * size.width));
  cv::Mat least;
  cv::erode(mean, least, cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U));
  const int step = std::max(1, static_cast<int>(0.008 * size.width));
  for (int y = reach; y < size.height - reach; ++y)
    for (int x = reach; x < size.width - reach; ++x) {
      const float here = mean.at<float>(y, x);
      if (here > -options_.least_kept_off || here > least.at<float>(y, x) ||
          here > -options_.sigmas * sigma.at<float>(y, x))
        continue;
      const auto at = [&](int dx, int dy) { return mean.at<float>(y + dy * step, x + dx * step); };
      const float xx = at(1, 0) + at(-1, 0) - 2 * here, yy = at(0, 1) + at(0, -1) - 2 * here,
                  xy = 0.25f * (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1));
      const float middle = 0.5f * (xx + yy), off = std::hypot(0.5f * (xx - yy), xy);
      if (middle - off < options_.round * (middle + off)) continue;
      spots_.push_back({{(static_cast<float>(x) + 0.5f) / static_cast<float>(size.width),
                         (static_cast<float>(y) + 0.5f) / static_cast<float>(size.height)},
                        1 - std::exp(static_cast<double>(here))});
    }
}

}  // namespace ulf::coverage
