#include "render/quality/quality.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ulf::render {
namespace {

// The constants are those of Wang et al. 2004, section III B.
constexpr int kWindow = 11;
constexpr double kSigma = 1.5, kLuminance = 0.01, kContrast = 0.03;

cv::Mat Blurred(const cv::Mat& image, int border = cv::BORDER_REFLECT_101) {
  cv::Mat result;
  cv::GaussianBlur(image, result, {kWindow, kWindow}, kSigma, kSigma, border);
  return result;
}

// Returns SSIM per pixel and channel, CV_64FC3. `mean` is that of a window; `covariance_factor` converts the
// window's covariance to a sample's.
template <typename MeanOf>
cv::Mat SsimMap(const cv::Mat& a8, const cv::Mat& b8, const MeanOf& mean, double covariance_factor = 1) {
  const double c1 = std::pow(kLuminance * 255, 2), c2 = std::pow(kContrast * 255, 2);
  cv::Mat a, b;
  a8.convertTo(a, CV_64F);
  b8.convertTo(b, CV_64F);
  const cv::Mat mean_a = mean(a), mean_b = mean(b);
  const cv::Mat var_a = covariance_factor * (mean(a.mul(a)) - mean_a.mul(mean_a));
  const cv::Mat var_b = covariance_factor * (mean(b.mul(b)) - mean_b.mul(mean_b));
  const cv::Mat covariance = covariance_factor * (mean(a.mul(b)) - mean_a.mul(mean_b));
  const auto plus = [](const cv::Mat& m, double c) { return cv::Mat(m + cv::Scalar::all(c)); };
  const cv::Mat numerator = plus(2 * mean_a.mul(mean_b), c1).mul(plus(2 * covariance, c2));
  const cv::Mat denominator = plus(mean_a.mul(mean_a) + mean_b.mul(mean_b), c1).mul(plus(var_a + var_b, c2));
  cv::Mat map;
  cv::divide(numerator, denominator, map);
  return map;
}

double MeanOfChannels(const cv::Scalar& mean) { return (mean[0] + mean[1] + mean[2]) / 3; }

}  // namespace

Quality CompareImages(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& mask) {
  constexpr double kMostDb = 100;
  Quality quality;
  quality.pixels = cv::countNonZero(mask);
  if (quality.pixels == 0) return quality;
  cv::Mat difference;
  cv::absdiff(rendered, photograph, difference);
  difference.convertTo(difference, CV_64F);
  const double mean_square = MeanOfChannels(cv::mean(difference.mul(difference), mask));
  quality.psnr_db = mean_square > 0 ? std::min(kMostDb, 10 * std::log10(255 * 255 / mean_square)) : kMostDb;

  constexpr int kMargin = kWindow / 2;
  if (rendered.cols <= 2 * kMargin || rendered.rows <= 2 * kMargin) return quality;
  const cv::Rect inner(kMargin, kMargin, rendered.cols - 2 * kMargin, rendered.rows - 2 * kMargin);
  if (cv::countNonZero(mask(inner)) > 0)
    quality.ssim = MeanOfChannels(cv::mean(
        SsimMap(rendered, photograph, [](const cv::Mat& m) { return Blurred(m); })(inner), mask(inner)));
  return quality;
}

double SsimUniform(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& mask) {
  constexpr int kSide = 7, kEdge = kSide / 2;
  constexpr double kSamples = kSide * kSide;
  if (rendered.cols <= 2 * kEdge || rendered.rows <= 2 * kEdge) return 0;
  const auto mean = [](const cv::Mat& image) {
    cv::Mat result;
    cv::boxFilter(image, result, -1, {kSide, kSide}, {-1, -1}, true, cv::BORDER_REFLECT);
    return result;
  };
  const cv::Rect inner(kEdge, kEdge, rendered.cols - 2 * kEdge, rendered.rows - 2 * kEdge);
  return MeanOfChannels(
      cv::mean(SsimMap(rendered, photograph, mean, kSamples / (kSamples - 1))(inner), mask(inner)));
}

double SsimPadded(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& mask) {
  const cv::Mat map =
      SsimMap(rendered, photograph, [](const cv::Mat& image) { return Blurred(image, cv::BORDER_CONSTANT); });
  return MeanOfChannels(cv::mean(map, mask));
}

}  // namespace ulf::render
