#include "coverage/session/watch/dust_watch.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace ulf::coverage {
namespace {

// Settled on simulated scenes (docs/capture.md#mistakes).
constexpr double kDustMoved = 0.03;  // share of the picture's width: what a place showed has moved away
constexpr double kDustAlike = 0.7;   // least correlation of a piece of the scene in two looks
constexpr double kDustPlain = 0.03;  // standard deviation of the light of a piece that needs none
constexpr double kDustEvery_s = 1, kDustStays_s = 3;  // spots are looked for so often, and are there so long
constexpr double kDustSigmas = 7;                     // of the mean over the looks
constexpr double kDustRound = 0.4;  // least curvature over the greatest: less is the edge of something
constexpr int kDustFewestLooks = 10;
constexpr double kDustLeastKeptOff = 0.04;
constexpr double kDustMostLooks = 0.85;  // share of the looks that must show it

// Returns the logarithm of the light over that around, for spots from one to three hundredths of the width.
cv::Mat SpotContrast(const cv::Mat& log_light) {
  const double width = log_light.cols;
  const auto odd = [](double px) { return 2 * static_cast<int>(0.5 * px) + 1; };
  const int spot = odd(0.008 * width), around = odd(0.05 * width);
  cv::Mat near, far;
  cv::blur(log_light, near, {spot, spot});
  cv::blur(log_light, far, {around, around});
  return near - far;
}

}  // namespace

cv::Rect DustWatch::Area(int row, int column) const {
  const cv::Size size = sum_.size();
  return {cv::Point(column * size.width / kColumns, row * size.height / kRows),
          cv::Point((column + 1) * size.width / kColumns, (row + 1) * size.height / kRows)};
}

void DustWatch::CompareCell(const cv::Rect& area, const cv::Mat& log_light, const cv::Mat& contrast,
                            Cell& cell) {
  if (cell.contrast.empty()) return;
  // In the look before, this piece of the scene was near where its points say.
  const int search = std::max(2, log_light.cols / 100);
  const cv::Rect near(area.x - cvRound(cell.moved.x) - search, area.y - cvRound(cell.moved.y) - search,
                      area.width + 2 * search, area.height + 2 * search);
  if ((near & cv::Rect({0, 0}, log_light.size())) != near) return;
  const cv::Mat piece = log_light(area);
  cv::Mat alike;
  cv::matchTemplate(cell.log_light(near), piece, alike, cv::TM_CCOEFF_NORMED);
  double best = 0;
  cv::Point at;
  cv::minMaxLoc(alike, nullptr, &best, nullptr, &at);
  cv::Scalar mean, deviation;
  cv::meanStdDev(piece, mean, deviation);
  if (deviation[0] < kDustPlain)
    at = {search, search};
  else if (best < kDustAlike)
    return;
  constexpr float kMost = 0.5f;  // what does not fit counts for no more
  const cv::Mat there = cell.contrast(cv::Rect(near.tl() + at, area.size()));
  const cv::Mat change = cv::min(cv::max(contrast(area) - there, -kMost), kMost);
  sum_(area) += change;
  cv::accumulateSquare(change, sum2_(area));
  cv::add(darker_(area), 1, darker_(area), change < -0.5 * kDustLeastKeptOff);
  ++cell.looks;
}

void DustWatch::Update(const PicturePair& pair) {
  const cv::Size size = pair.log_light.size();
  if (sum_.size() != size) {
    sum_ = cv::Mat::zeros(size, CV_32F);
    sum2_ = cv::Mat::zeros(size, CV_32F);
    darker_ = cv::Mat::zeros(size, CV_32F);
    cells_.assign(kColumns * kRows, {});
    candidates_.clear();
    spots_.clear();
  }
  // The motion of the points in and around each cell or, where there is none, of all.
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
      const auto index = static_cast<std::size_t>(row * kColumns + column);
      Cell& cell = cells_[index];
      cell.moved += points[index] > 0 ? motion[index] / static_cast<float>(points[index]) : pair.motion;
      const bool is_first = cell.contrast.empty();
      if (!is_first && std::hypot(cell.moved.x, cell.moved.y) < kDustMoved * size.width) continue;
      if (contrast.empty()) contrast = SpotContrast(pair.log_light);
      CompareCell(Area(row, column), pair.log_light, contrast, cell);
      cell.log_light = pair.log_light;
      cell.contrast = contrast;
      cell.moved = {};
    }
  if (pair.now_s - looked_s_ < kDustEvery_s && pair.now_s >= looked_s_) return;
  looked_s_ = pair.now_s;
  LookForSpots();
}

void DustWatch::LookForSpots() {
  std::vector<Candidate> found;
  const cv::Size size = sum_.size();
  cv::Mat mean = cv::Mat::zeros(size, CV_32F), sigma = cv::Mat::ones(size, CV_32F),
          darker = cv::Mat::zeros(size, CV_32F);
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const double looks = cells_[static_cast<std::size_t>(row * kColumns + column)].looks;
      if (looks < kDustFewestLooks) continue;
      const cv::Rect area = Area(row, column);
      const cv::Mat mean_here = sum_(area) / looks, variance = sum2_(area) / looks - mean_here.mul(mean_here);
      mean_here.copyTo(mean(area));
      cv::Mat(darker_(area) / looks).copyTo(darker(area));
      constexpr double kNoise = 4e-4;  // the deviations of few looks may be small by chance
      cv::sqrt(cv::max(variance, kNoise) / looks, sigma(area));
    }
  const int reach = std::max(2, static_cast<int>(0.02 * size.width));
  cv::Mat least;
  cv::erode(mean, least, cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U));
  const int step = std::max(1, static_cast<int>(0.008 * size.width));
  for (int y = reach; y < size.height - reach; ++y)
    for (int x = reach; x < size.width - reach; ++x) {
      const float here = mean.at<float>(y, x);
      if (here > -kDustLeastKeptOff || here > least.at<float>(y, x) ||
          here > -kDustSigmas * sigma.at<float>(y, x) || darker.at<float>(y, x) < kDustMostLooks)
        continue;
      const auto at = [&](int dx, int dy) { return mean.at<float>(y + dy * step, x + dx * step); };
      const float xx = at(1, 0) + at(-1, 0) - 2 * here, yy = at(0, 1) + at(0, -1) - 2 * here,
                  xy = 0.25f * (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1));
      const float middle = 0.5f * (xx + yy), off = std::hypot(0.5f * (xx - yy), xy);
      if (middle - off < kDustRound * (middle + off)) continue;
      const DustSpot spot{{(static_cast<float>(x) + 0.5f) / static_cast<float>(size.width),
                           (static_cast<float>(y) + 0.5f) / static_cast<float>(size.height)},
                          1 - std::exp(static_cast<double>(here))};
      constexpr float kSame = 0.01f;  // share of the picture's sides
      const auto before = std::ranges::find_if(candidates_, [&](const Candidate& candidate) {
        return std::abs(candidate.spot.at.x - spot.at.x) < kSame &&
               std::abs(candidate.spot.at.y - spot.at.y) < kSame;
      });
      found.push_back({spot, before == candidates_.end() ? looked_s_ : before->since_s});
    }
  candidates_ = std::move(found);
  spots_.clear();
  for (const Candidate& candidate : candidates_)
    if (looked_s_ - candidate.since_s >= kDustStays_s) spots_.push_back(candidate.spot);
}

}  // namespace ulf::coverage
