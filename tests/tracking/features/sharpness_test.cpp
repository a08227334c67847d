// Tests: tracking/features/sharpness.
#include "tracking/features/sharpness.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"

namespace ulf::sharpness_test {
namespace {

cv::Mat GrayAt(int frame) {
  static const test::TexturedRoom room{{}};
  return GrayForTracking(
      room.Take(test::TexturedRoom::HandAt(frame), static_cast<std::uint64_t>(frame)).image);
}

TEST(SharpnessTest, ABlurredFrameStandsOut) {
  Sharpness sharpness;
  EXPECT_DOUBLE_EQ(sharpness.Step(ForSharpness(GrayAt(0))), 1) << "there is nothing to compare with";
  for (int k = 1; k < 10; ++k) {
    const double sharp = sharpness.Step(ForSharpness(GrayAt(k)));
    EXPECT_GT(sharp, 0.7) << k;
    EXPECT_LT(sharp, 1.5) << k;
  }
  cv::Mat blurred;
  cv::blur(GrayAt(10), blurred, {9, 9});
  EXPECT_LT(sharpness.Step(ForSharpness(blurred)), 0.5);
}

TEST(SharpnessTest, IsMeasuredOnAtMost2000Pixels) {
  EXPECT_EQ(ForSharpness(cv::Mat(3000, 4000, CV_8UC1)).size(), cv::Size(2000, 1500));
  EXPECT_EQ(ForSharpness(cv::Mat(480, 640, CV_8UC1)).size(), cv::Size(444, 333));
}

}  // namespace
}  // namespace ulf::sharpness_test
