// Tests: coverage/bound/subject_light.
#include "coverage/bound/subject_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/floors.h"

namespace ulf::test::subject_light_test {
namespace {

std::vector<Eigen::Vector2d> Circle(double x, double y, double radius) {
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < 64; ++i)
    outline.push_back({x + radius * std::cos(2 * M_PI * i / 64), y + radius * std::sin(2 * M_PI * i / 64)});
  return outline;
}

// A third of the circle clipped, the rest grey; outside it black, which does not count.
TEST(SubjectLight, CountsOnlyInsideTheOutline) {
  constexpr double kGrey = 0.5;
  Image image;
  image.transfer = Transfer::kSrgb;
  image.pixels = cv::Mat::zeros(240, 320, CV_8UC3);
  image.pixels(cv::Rect(100, 60, 120, 120)) = cv::Scalar::all(std::lround(255 * kGrey));
  image.pixels(cv::Rect(100, 60, 120, 44)) = cv::Scalar(20, 255, 20);  // its brightest channel counts
  const auto light = LightInside(image, Circle(160, 120, 60));
  ASSERT_TRUE(light);
  // Of a circle, what lies above 16 px over its middle.
  const double above = (std::acos(16.0 / 60) - 16.0 / 60 * std::sqrt(1 - 16.0 / 60 * 16 / 60)) / M_PI;
  EXPECT_NEAR(light->clipped_share, above, 0.03);
  EXPECT_FLOAT_EQ(static_cast<float>(light->brightest_tenth), 1);
  EXPECT_NEAR(light->mean_linear, above + (1 - above) * LinearFromSrgb(kGrey), 0.03);
}

TEST(SubjectLight, SmallBrightSpotIsTheTopHundredth) {
  Image image;
  image.transfer = Transfer::kSrgb;
  image.pixels = cv::Mat::zeros(200, 200, CV_8UC1);
  image.pixels(cv::Rect(90, 90, 20, 20)) = cv::Scalar(204);  // 5 % of the circle
  const auto light = LightInside(image, Circle(100, 100, 50));
  ASSERT_TRUE(light);
  EXPECT_EQ(light->brightest_tenth, 0);
  EXPECT_NEAR(light->brightest_hundredth, 0.8, 0.01);
}

TEST(SubjectLight, IsTheSameOfLinearLightInSixteenBits) {
  for (const double encoded : {0.1, 0.4, 0.9}) {
    Image srgb, linear;
    srgb.transfer = Transfer::kSrgb, linear.transfer = Transfer::kLinear;
    srgb.pixels = cv::Mat(100, 100, CV_8UC1, cv::Scalar(std::lround(255 * encoded)));
    linear.pixels = cv::Mat(100, 100, CV_16UC1,
                            cv::Scalar(std::lround(65535 * LinearFromSrgb(static_cast<float>(encoded)))));
    const auto a = LightInside(srgb, Circle(50, 50, 30)), b = LightInside(linear, Circle(50, 50, 30));
    ASSERT_TRUE(a && b);
    EXPECT_NEAR(a->brightest_tenth, encoded, 0.01);
    EXPECT_NEAR(b->brightest_tenth, encoded, 0.01);
    EXPECT_NEAR(b->brightest_hundredth, encoded, 0.01);
    EXPECT_NEAR(a->mean_linear, b->mean_linear, 0.01);
    EXPECT_EQ(b->clipped_share, 0);
  }
}

}  // namespace
}  // namespace ulf::test::subject_light_test
