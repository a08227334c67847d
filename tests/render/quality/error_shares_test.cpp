// Tests: render/quality/error_shares.
#include "render/quality/error_shares.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/support/floors.h"

namespace ulf::test {
namespace {

// Left half near, right half far; texture in the lower half; the upper left corner is seen by nobody.
TEST(ErrorShares, FindTheKindThatIsWrong) {
  const cv::Size size(80, 60);
  cv::Mat photograph(size, CV_8UC3, cv::Scalar(100, 100, 100)), depth(size, CV_32F, cv::Scalar(2)),
      confidence(size, CV_32F, cv::Scalar(1)), valid(size, CV_8U, cv::Scalar(255));
  cv::RNG random(1);
  cv::Mat lower = photograph.rowRange(40, 60);
  random.fill(lower, cv::RNG::UNIFORM, 0, 255);
  depth.colRange(40, 80).setTo(4);
  confidence(cv::Rect(0, 0, 10, 10)).setTo(0);
  const auto share_of = [&](const cv::Rect& wrong, ErrorKind kind) {
    cv::Mat rendered = photograph.clone();
    rendered(wrong) += cv::Scalar(20, 20, 20);
    return ShareErrors(rendered, photograph, valid, depth, confidence)
        .of_error[static_cast<std::size_t>(kind)];
  };
  EXPECT_EQ(share_of({2, 2, 5, 5}, ErrorKind::kUnseen), 1);
  EXPECT_EQ(share_of({38, 10, 4, 20}, ErrorKind::kEdge), 1);
  EXPECT_GT(share_of({10, 46, 20, 10}, ErrorKind::kTextured), 0.99);
  EXPECT_EQ(share_of({15, 15, 10, 10}, ErrorKind::kPlain), 1);
  EXPECT_EQ(share_of({60, 15, 10, 10}, ErrorKind::kPlain), 1);
}

TEST(ErrorShares, CountWhatIsValidAndTheWorst) {
  const cv::Size size(50, 40);
  const cv::Mat photograph(size, CV_8UC3, cv::Scalar(100, 100, 100)), depth(size, CV_32F, cv::Scalar(2)),
      confidence(size, CV_32F, cv::Scalar(1));
  cv::Mat valid(size, CV_8U, cv::Scalar(255)), rendered = photograph + cv::Scalar(1, 1, 1);
  valid.colRange(0, 25).setTo(0);
  rendered.colRange(0, 25).setTo(0);
  rendered(cv::Rect(30, 10, 2, 5)).setTo(cv::Scalar(200, 200, 200));  // ten of the thousand that count
  const ErrorShares shares = ShareErrors(rendered, photograph, valid, depth, confidence);
  const double worst = 10 * 3 * 100.0 * 100.0, rest = 990 * 3;
  EXPECT_NEAR(shares.of_worst_hundredth, worst / (worst + rest), 1e-12);
  EXPECT_EQ(shares.of_pixels[static_cast<std::size_t>(ErrorKind::kPlain)], 1);
  const ErrorShares none = ShareErrors(photograph, photograph, valid, depth, confidence);
  EXPECT_EQ(none.of_worst_hundredth, 0);
}

}  // namespace
}  // namespace ulf::test
