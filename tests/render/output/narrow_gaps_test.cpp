// Tests: render/output/picture_files.
#include "render/output/picture_files.h"

#include <gtest/gtest.h>

#include "tests/support/floors.h"

namespace ulf::test::narrow_gaps_test {
namespace {

TEST(NarrowGaps, AreClosedWithWhatIsBesideThem) {
  const cv::Size size(200, 100);
  cv::Mat linear(size, CV_32FC3, cv::Scalar(0.2, 0.4, 0.6)), drawn(size, CV_8U, cv::Scalar(255));
  const cv::Rect sliver(0, 0, 4, 100), wide(120, 0, 80, 100);
  for (const cv::Rect& gap : {sliver, wide}) {
    linear(gap).setTo(0);
    drawn(gap).setTo(0);
  }
  const cv::Mat before = linear.clone(), closed = WithNarrowGapsClosed(linear, drawn);
  EXPECT_EQ(cv::norm(linear, before, cv::NORM_INF), 0) << "the rendering stays as it is";
  EXPECT_EQ(closed.at<cv::Vec3f>(50, 0), cv::Vec3f(0.2f, 0.4f, 0.6f));
  EXPECT_EQ(closed.at<cv::Vec3f>(50, 121), cv::Vec3f(0, 0, 0)) << "no rim of a wide gap is made up";
  EXPECT_EQ(closed.at<cv::Vec3f>(50, 150), cv::Vec3f(0, 0, 0)) << "nobody knows what is there";
  EXPECT_EQ(closed.at<cv::Vec3f>(50, 60), before.at<cv::Vec3f>(50, 60));
}

TEST(NarrowGaps, LeaveEmptyAndWholePicturesAlone) {
  const cv::Mat linear(20, 30, CV_32FC3, cv::Scalar(0.1, 0.1, 0.1));
  for (const int drawn : {0, 255})
    EXPECT_EQ(cv::norm(WithNarrowGapsClosed(linear, cv::Mat(20, 30, CV_8U, cv::Scalar(drawn))), linear,
                       cv::NORM_INF),
              0);
}

}  // namespace
}  // namespace ulf::test::narrow_gaps_test
