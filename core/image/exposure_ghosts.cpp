#include "core/image/exposure_ghosts.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/quantile.h"
#include "core/image/clipped.h"

namespace ulf {
namespace {

constexpr double kWrongTimes = 0.02, kGhostSigmas = 4;  // guessed
constexpr double kMostNoisier = 4;                      // largest ratio to the measured variance; guessed
constexpr std::size_t kFewPixels = 500;                 // needed to measure the variance
constexpr int kAcross = 3;                              // px, window of a mean

// Returns the reference first, then exposures by nearness to it, shorter before longer.
std::vector<std::size_t> InOrderOfTrust(std::span<const AlignedExposure> exposures) {
  std::vector<std::size_t> order(exposures.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) {
    const double stops = std::log2(exposures[i].ratio);
    return std::pair(std::abs(stops), stops);
  });
  return order;
}

// Returns the variance of the light in each of three colours.
cv::Mat VarianceOf(const AlignedExposure& exposure, const cv::Mat& light) {
  const double ratio = exposure.ratio;
  return (cv::max(light, 0) * (exposure.noise.per_light * ratio) + cv::Scalar::all(exposure.noise.floor)) /
         (ratio * ratio);
}

cv::Mat SumAround(const cv::Mat& numbers) {
  cv::Mat sum;
  cv::boxFilter(numbers, sum, -1, {kAcross, kAcross}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return sum;
}

// Returns the square of the allowed difference between the exposure and the reference light besides noise.
cv::Mat AllowedSquares(std::span<const AlignedExposure> exposures, std::size_t index,
                       const GhostReference& alone) {
  const cv::Mat slope = SlopeOf(alone.light, alone.variance);
  cv::Mat squares_px(1, 256, CV_32FC1, cv::Scalar(0)), off;  // of misalignments, by the reference's exposure
  for (std::size_t i = 0; i < exposures.size(); ++i)
    squares_px.at<float>(static_cast<int>(i)) = static_cast<float>(
        std::pow(exposures[index].misaligned_px, 2) + std::pow(exposures[i].misaligned_px, 2));
  cv::LUT(alone.which, squares_px, off);
  return off.mul(slope.mul(slope)) + kWrongTimes * kWrongTimes * alone.light.mul(alone.light);
}

// Returns the ratio of the variance of means to that of uncorrelated pixels, measured in pixels in which
// nothing else can be large.
double Noisier(const cv::Mat& squares, const cv::Mat& variance, const cv::Mat& allowed,
               const cv::Mat& compared) {
  constexpr double kMedianOfChiSquare = 0.4549;
  const cv::Mat measured = compared & (allowed < variance), ratios = squares / variance;
  std::vector<double> of_noise;
  for (int y = 0; y < measured.rows; ++y)
    for (int i = 0; i < 3 * measured.cols; ++i)
      if (measured.ptr(y)[i] != 0) of_noise.push_back(ratios.ptr<float>(y)[i]);
  if (of_noise.size() < kFewPixels) return 1;
  return std::clamp(Median(of_noise) / kMedianOfChiSquare, 1.0, kMostNoisier);
}

}  // namespace

GhostReference GhostReferenceOf(std::span<const AlignedExposure> exposures) {
  const std::vector<std::size_t> order = InOrderOfTrust(exposures);
  const cv::Size size = exposures[0].light.size();
  GhostReference alone{cv::Mat(size, CV_8UC3), cv::Mat(size, CV_32FC3), cv::Mat(size, CV_32FC3),
                       cv::Mat::zeros(size, CV_8UC3)};
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      for (int c = 0; c < 3; ++c) {
        std::optional<std::size_t> chosen;
        std::size_t shortest = 0;
        for (const std::size_t i : order) {
          if (exposures[i].seen.at<std::uint8_t>(y, x) == 0) continue;
          if (exposures[i].ratio < exposures[shortest].ratio) shortest = i;
          if (!chosen && exposures[i].clipped.at<cv::Vec3b>(y, x)[c] == 0) chosen = i;
        }
        if (!chosen) alone.clipped.at<cv::Vec3b>(y, x)[c] = 255;
        const std::size_t which = chosen.value_or(shortest);
        const float light = exposures[which].LightAt(y, x)[c];
        alone.which.at<cv::Vec3b>(y, x)[c] = static_cast<std::uint8_t>(which);
        alone.light.at<cv::Vec3f>(y, x)[c] = light;
        alone.variance.at<cv::Vec3f>(y, x)[c] = static_cast<float>(exposures[which].VarianceAt(light));
      }
  return alone;
}

cv::Mat SlopeOf(const cv::Mat& light, const cv::Mat& variance) {
  cv::Mat by_x, by_y, slope;
  cv::Sobel(light, by_x, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(light, by_y, CV_32F, 0, 1, 3, 1.0 / 8);
  cv::Mat squares = by_x.mul(by_x) + by_y.mul(by_y);
  constexpr double kOfNoise = 2 * 12.0 / 64;  // sum of squared coefficients of the kernels
  if (!variance.empty()) squares -= kOfNoise * variance;
  cv::sqrt(cv::max(squares, 0), slope);
  cv::dilate(slope, slope, cv::Mat::ones(3, 3, CV_8UC1));
  return slope;
}

cv::Mat GhostsIn(std::span<const AlignedExposure> exposures, std::size_t index, const GhostReference& alone) {
  const AlignedExposure& exposure = exposures[index];
  const cv::Mat lower_bound = InThreeColors(exposure.seen) & exposure.clipped & ~alone.clipped;
  const cv::Mat compared = ((exposure.Usable() & ~alone.clipped) | lower_bound) &
                           (alone.which != cv::Scalar::all(static_cast<double>(index)));
  // The difference is 0 at invalid pixels, and if the exposure's lower bound holds.
  cv::Mat difference = exposure.light / exposure.ratio - alone.light;
  const cv::Mat too_bright = cv::max(difference, 0);
  too_bright.copyTo(difference, lower_bound);
  difference.setTo(0, ~compared);
  cv::Mat variance = VarianceOf(exposure, alone.light) + alone.variance;
  variance.setTo(0, ~compared);
  cv::Mat ones;
  compared.convertTo(ones, CV_32F, 1.0 / 255);
  const cv::Mat count = cv::max(SumAround(ones), 1);
  const cv::Mat mean = SumAround(difference) / count;
  const cv::Mat squares = mean.mul(mean), noise = SumAround(variance) / count.mul(count);
  const cv::Mat allowed = AllowedSquares(exposures, index, alone);
  const double noisier = Noisier(squares, noise, allowed, compared & ~lower_bound);
  cv::Mat ghosts = AnyColor(
      (squares / (noisier * noise + allowed) > cv::Scalar::all(kGhostSigmas * kGhostSigmas)) & compared);
  // A single pixel is noise; a moving object has a border of mixed pixels.
  const cv::Mat around = cv::Mat::ones(3, 3, CV_8UC1);
  cv::morphologyEx(ghosts, ghosts, cv::MORPH_OPEN, around);
  cv::dilate(ghosts, ghosts, around);
  return ghosts & AnyColor(compared);
}

}  // namespace ulf
