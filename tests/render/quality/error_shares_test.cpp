// Tests: render/quality/error_shares.
#include "render/quality/error_shares.h"

#include <gtest/gtest.h>

#include <numeric>
#include <opencv2/imgproc.hpp>

#include "tests/support/floors.h"

namespace ulf::test::error_shares_test {
namespace {

// Random texture, smooth enough that a displacement by half a pixel is still a picture of it.
cv::Mat Texture(cv::Size size) {
  cv::Mat texture(size, CV_8UC3);
  cv::RNG random(1);
  random.fill(texture, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(texture, texture, {}, 1.2);
  cv::normalize(texture, texture, 40, 215, cv::NORM_MINMAX);
  return texture;
}

struct SharedScene {
  cv::Size size{160, 120};
  cv::Mat photograph = Texture(size), depth = cv::Mat(size, CV_32F, cv::Scalar(4)),
          confidence = cv::Mat(size, CV_32F, cv::Scalar(1)), valid = cv::Mat(size, CV_8U, cv::Scalar(255));

  // Of the error of a rendering that is `wrong` inside `where` and right elsewhere.
  double ShareOf(ErrorKind kind, const cv::Mat& wrong, const cv::Rect& where) const {
    cv::Mat rendered = photograph.clone();
    wrong(where).copyTo(rendered(where));
    return ShareErrors(rendered, photograph, valid, depth, confidence)
        .of_error[static_cast<std::size_t>(kind)];
  }
};

TEST(ErrorShares, FindTheGeometryThatIsWrong) {
  SharedScene scene;
  scene.depth.colRange(0, 60).setTo(2);             // a wide step
  scene.depth(cv::Rect(110, 10, 5, 100)).setTo(1);  // a near post of five pixels
  scene.depth(cv::Rect(130, 10, 5, 100)).setTo(8);  // a slit of five pixels
  scene.confidence(cv::Rect(0, 0, 10, 10)).setTo(0);
  const cv::Mat brighter = scene.photograph + cv::Scalar(20, 20, 20);
  EXPECT_EQ(scene.ShareOf(ErrorKind::kUnseen, brighter, {2, 2, 5, 5}), 1);
  EXPECT_EQ(scene.ShareOf(ErrorKind::kEdge, brighter, {58, 20, 4, 60}), 1);
  EXPECT_EQ(scene.ShareOf(ErrorKind::kThin, brighter, {108, 20, 9, 60}), 1);
  EXPECT_EQ(scene.ShareOf(ErrorKind::kEdge, brighter, {132, 20, 2, 60}), 1);
}

TEST(ErrorShares, TellBlurDisplacementAndLightApart) {
  const SharedScene scene;
  const cv::Rect inside(30, 20, 100, 80);
  cv::Mat blurred, displaced, nonsense;
  cv::GaussianBlur(scene.photograph, blurred, {}, 1.5);
  cv::warpAffine(scene.photograph, displaced, cv::Matx23d(1, 0, 0.7, 0, 1, -0.3), scene.size);
  cv::flip(scene.photograph, nonsense, 1);
  EXPECT_GT(scene.ShareOf(ErrorKind::kBlurred, blurred, inside), 0.9);
  EXPECT_GT(scene.ShareOf(ErrorKind::kDisplaced, displaced, inside), 0.9);
  EXPECT_GT(scene.ShareOf(ErrorKind::kLight, scene.photograph + cv::Scalar(9, 2, -6), inside), 0.9);
  EXPECT_GT(scene.ShareOf(ErrorKind::kOther, nonsense, inside), 0.9);
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
  EXPECT_NEAR(std::accumulate(shares.of_pixels.begin(), shares.of_pixels.end(), 0.0), 1, 1e-12);
  const ErrorShares none = ShareErrors(photograph, photograph, valid, depth, confidence);
  EXPECT_EQ(none.of_worst_hundredth, 0);
}

}  // namespace
}  // namespace ulf::test::error_shares_test
