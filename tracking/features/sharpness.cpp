#include "tracking/features/sharpness.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "core/base/quantile.h"
#include "tracking/features/features.h"

namespace ulf::tracking {
namespace {

constexpr int kWidestDetail = 2000;  // px: then the sums of a row fit 32 bits whatever it shows

// Returns the energy of fine detail: the variance of the Laplacian.
double DetailOf(const cv::Mat& image) {
  std::int64_t sum = 0, sum2 = 0;
  for (int y = 1; y + 1 < image.rows; ++y) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y);
    const std::uint8_t *above = row - image.step, *below = row + image.step;
    std::int32_t row_sum = 0, row_sum2 = 0;
    for (int x = 1; x + 1 < image.cols; ++x) {
      const std::int32_t laplacian = above[x] + below[x] + row[x - 1] + row[x + 1] - 4 * row[x];
      row_sum += laplacian;
      row_sum2 += laplacian * laplacian;
    }
    sum += row_sum;
    sum2 += row_sum2;
  }
  const double count = std::max(1.0, static_cast<double>(image.cols - 2) * (image.rows - 2));
  const double mean = static_cast<double>(sum) / count;
  return static_cast<double>(sum2) / count - mean * mean;
}

}  // namespace

cv::Mat ForSharpness(const cv::Mat& gray) {
  const double scale =
      std::min(1 / LevelScale(kSharpnessLevel), static_cast<double>(kWidestDetail) / gray.cols);
  cv::Mat reduced;
  cv::resize(gray, reduced,
             {std::max(1, static_cast<int>(std::lround(scale * gray.cols))),
              std::max(1, static_cast<int>(std::lround(scale * gray.rows)))},
             0, 0, cv::INTER_LINEAR);
  return reduced;
}

double Sharpness::Step(const cv::Mat& reduced) {
  const double detail = DetailOf(reduced);
  const double usual = Median({recent_.begin(), recent_.end()});
  recent_.push_back(detail);
  if (recent_.size() > kRecent) recent_.pop_front();
  return usual > 0 ? detail / usual : 1;
}

}  // namespace ulf::tracking
