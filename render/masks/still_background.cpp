#include "render/masks/still_background.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"

namespace ulf::render {
namespace {

using Pixel = cv::Vec3b;

// From the differences between neighbouring pictures, of the quieter half: what turns makes the others.
float NoiseOf(std::span<const cv::Mat> pictures) {
  std::vector<double> differences;
  constexpr int kStep = 7;
  for (std::size_t i = 1; i < pictures.size(); ++i)
    for (int y = 0; y < pictures[i].rows; y += kStep)
      for (int x = 0; x < pictures[i].cols; x += kStep)
        differences.push_back(std::abs(pictures[i].at<Pixel>(y, x)[1] - pictures[i - 1].at<Pixel>(y, x)[1]));
  if (differences.empty()) return 1;
  // The mean of the lower 40 % of absolute differences of a normal distribution is 0.26 of its deviation, which
  // rounding to levels leaves as it is.
  constexpr double kLower = 0.4, kMeanOfLower = 0.26;
  std::sort(differences.begin(), differences.end());
  differences.resize(
      std::max<std::size_t>(1, static_cast<std::size_t>(kLower * static_cast<double>(differences.size()))));
  double sum = 0;
  for (const double each : differences) sum += each;
  const double mean = sum / static_cast<double>(differences.size());
  return std::max(1.0f, static_cast<float>(mean / kMeanOfLower / std::sqrt(2.0)));
}

int Apart(const Pixel& a, const Pixel& b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

struct Mode {
  cv::Vec3f color{0, 0, 0};
  std::size_t count = 0;    // of pictures that agree
  std::size_t in_runs = 0;  // of these, one after the other
};

Mode ModeOf(const std::vector<Pixel>& values, int tolerance, std::size_t run, std::vector<char>& agrees) {
  Mode mode;
  std::size_t best = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::size_t count = 0;
    for (const Pixel& other : values) count += Apart(values[i], other) <= tolerance;
    if (count > mode.count) mode.count = count, best = i;
    if (2 * count > values.size()) break;
  }
  agrees.assign(values.size(), 0);
  cv::Vec3f sum(0, 0, 0);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (Apart(values[best], values[i]) <= tolerance) {
      agrees[i] = 1;
      sum += cv::Vec3f(values[i][0], values[i][1], values[i][2]);
    }
  mode.color = sum / static_cast<float>(std::max<std::size_t>(1, mode.count));
  for (std::size_t i = 0; i < values.size();) {
    std::size_t end = i;
    while (end < values.size() && agrees[end]) ++end;
    if (end - i >= run) mode.in_runs += end - i;
    i = std::max(end, i + 1);
  }
  return mode;
}

}  // namespace

StillBackground LearnBackground(std::span<const cv::Mat> pictures, std::span<const cv::Mat> turning,
                                const StillBackgroundOptions& options) {
  CV_Assert(!pictures.empty() && (turning.empty() || turning.size() == pictures.size()));
  const cv::Size size = pictures[0].size();
  StillBackground background{cv::Mat::zeros(size, CV_32FC3), cv::Mat::zeros(size, CV_32F),
                             cv::Mat::zeros(size, CV_8U), NoiseOf(pictures)};
  const int tolerance = static_cast<int>(std::lround(std::clamp(
      static_cast<float>(options.agree_sigmas) * background.noise, options.least_agree, options.most_agree)));
  const auto all = static_cast<double>(pictures.size());
  ParallelFor(At(size.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    std::vector<Pixel> values;
    std::vector<char> agrees;
    for (int x = 0; x < size.width; ++x) {
      values.clear();
      for (std::size_t i = 0; i < pictures.size(); ++i)
        if (turning.empty() || turning[i].empty() || turning[i].at<std::uint8_t>(y, x) == 0)
          values.push_back(pictures[i].at<Pixel>(y, x));
      if (values.size() < options.run) continue;
      const Mode mode = ModeOf(values, tolerance, options.run, agrees);
      background.color.at<cv::Vec3f>(y, x) = mode.color;
      const bool still = static_cast<double>(mode.count) >= options.still_share * all;
      background.still.at<std::uint8_t>(y, x) = still ? 255 : 0;
      const double share = static_cast<double>(mode.in_runs) / all;
      background.known.at<float>(y, x) =
          still ? 1.0f
                : static_cast<float>(std::clamp(
                      (share - options.doubted_share) / (options.known_share - options.doubted_share), 0.0,
                      1.0));
    }
  });
  return background;
}

cv::Point2d ShiftAgainst(const StillBackground& background, const cv::Mat& picture) {
  // Least squares of Lucas and Kanade (1981) over the still pixels; the gradients are the background's.
  cv::Mat grey, moved, dx, dy;
  cv::cvtColor(background.color, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, grey, {}, 1);
  cv::Sobel(grey, dx, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(grey, dy, CV_32F, 0, 1, 3, 1.0 / 8);
  cv::Mat own;
  cv::cvtColor(picture, own, cv::COLOR_BGR2GRAY);
  own.convertTo(own, CV_32F);
  cv::GaussianBlur(own, own, {}, 1);
  cv::Point2d shift(0, 0);
  constexpr int kRounds = 6, kRim = 4;
  constexpr float kOutlier = 40;  // levels; guessed
  for (int round = 0; round < kRounds; ++round) {
    const cv::Matx23d by(1, 0, shift.x, 0, 1, shift.y);
    cv::warpAffine(own, moved, by, own.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
    cv::Matx22d normal = cv::Matx22d::zeros();
    cv::Vec2d right(0, 0);
    for (int y = kRim; y < own.rows - kRim; ++y)
      for (int x = kRim; x < own.cols - kRim; ++x) {
        const float known = background.known.at<float>(y, x);
        if (known < 0.99f) continue;
        const float difference = grey.at<float>(y, x) - moved.at<float>(y, x);
        if (std::abs(difference) > kOutlier) continue;
        const cv::Vec2d g(dx.at<float>(y, x), dy.at<float>(y, x));
        normal += g * g.t();
        right += difference * g;
      }
    if (cv::determinant(normal) < 1) return shift;  // nothing there has an edge
    const cv::Vec2d step = normal.solve(right, cv::DECOMP_CHOLESKY);
    shift += cv::Point2d(step[0], step[1]);
    if (cv::norm(step) < 0.01) break;
  }
  return shift;
}

}  // namespace ulf::render
