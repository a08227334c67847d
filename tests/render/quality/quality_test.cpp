// Tests: render/quality/quality.
#include "render/quality/quality.h"
#include "tests/support/floors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ulf::quality_test {
namespace {

cv::Mat Noise(int seed) {
  cv::Mat image(64, 80, CV_8UC3);
  cv::RNG random(static_cast<std::uint64_t>(seed));
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {0, 0}, 2);
  return image;
}

const cv::Mat kAll(64, 80, CV_8U, cv::Scalar(255));

TEST(Quality, IdenticalPicturesAreBest) {
  const Quality quality = CompareImages(Noise(1), Noise(1), kAll);
  EXPECT_EQ(quality.psnr_db, 100);
  EXPECT_NEAR(quality.ssim, 1, 1e-12);
  EXPECT_EQ(quality.pixels, 64 * 80);
}

TEST(Quality, PsnrIsThatOfAKnownDifference) {
  const cv::Mat base(64, 80, CV_8UC3, cv::Scalar(100, 100, 100));
  for (const int step : {1, 5, 20}) {
    const cv::Mat other = base + cv::Scalar::all(step);
    EXPECT_NEAR(CompareImages(base, other, kAll).psnr_db, 20 * std::log10(255.0 / step), 1e-9) << step;
  }
}

// Constant pictures: variances vanish and SSIM is its luminance term alone.
TEST(Quality, SsimIsExactForConstantPictures) {
  const cv::Mat a(64, 80, CV_8UC3, cv::Scalar::all(100)), b(64, 80, CV_8UC3, cv::Scalar::all(140));
  const double c1 = std::pow(0.01 * 255, 2);
  const double expected = (2.0 * 100 * 140 + c1) / (100.0 * 100 + 140.0 * 140 + c1);
  EXPECT_NEAR(CompareImages(a, b, kAll).ssim, expected, 1e-6);
}

// Contrast and structure alone: b = -a about the common mean has covariance -variance.
TEST(Quality, SsimOfAnInvertedPictureIsNegative) {
  cv::Mat a(64, 80, CV_8UC3);
  cv::RNG(2).fill(a, cv::RNG::UNIFORM, 60, 196);
  const cv::Mat b = cv::Scalar::all(255) - a;
  EXPECT_LT(CompareImages(a, b, kAll).ssim, 0);
}

TEST(Quality, FallsWithMoreNoise) {
  const cv::Mat a = Noise(3);
  double last_psnr = 1000, last_ssim = 2;
  for (const double share : {0.05, 0.2, 0.5}) {
    cv::Mat b;
    cv::addWeighted(a, 1 - share, Noise(4), share, 0, b);
    const Quality quality = CompareImages(a, b, kAll);
    EXPECT_LT(quality.psnr_db, last_psnr);
    EXPECT_LT(quality.ssim, last_ssim);
    last_psnr = quality.psnr_db;
    last_ssim = quality.ssim;
  }
}

TEST(Quality, OnlyTheMaskCounts) {
  const cv::Mat a = Noise(5);
  cv::Mat b = a.clone();
  b.colRange(0, 30).setTo(cv::Scalar::all(0));
  cv::Mat mask = kAll.clone();
  mask.colRange(0, 40).setTo(0);
  const Quality quality = CompareImages(a, b, mask);
  EXPECT_EQ(quality.psnr_db, 100);
  EXPECT_NEAR(quality.ssim, 1, 1e-12);
  const Quality nothing = CompareImages(a, b, cv::Mat::zeros(a.size(), CV_8U));
  EXPECT_EQ(nothing.pixels, 0);
}

}  // namespace
}  // namespace ulf::quality_test
