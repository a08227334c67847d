// Tests: core/fiducials/marker_detector.
#include "core/fiducials/marker_detector.h"

#include <gmock/gmock.h>

#include <opencv2/aruco.hpp>

#include "core/base/error.h"

namespace ulf {
namespace {

TEST(MarkerDetector, FindsNumberAndSubpixelCorners) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  cv::Mat marker, page(240, 320, CV_8UC1, cv::Scalar(255));
  cv::aruco::drawMarker(dictionary, 17, 90, marker);
  marker.copyTo(page(cv::Rect(100, 60, 90, 90)));
  const auto found = DetectMarkers("DICT_4X4_50", page);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].first, 17);
  // Pixel centres are at integer + 0.5: the edges of the marker's pixels are whole numbers.
  const MarkerImage truth{{{100, 60}, {190, 60}, {190, 150}, {100, 150}}};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((found[0].second[i] - truth[i]).norm(), 0.2) << i;
  EXPECT_THROW(DetectMarkers("DICT_9X9", page), Refusal);
  EXPECT_TRUE(DetectMarkers("DICT_4X4_50", cv::Mat(240, 320, CV_8UC1, cv::Scalar(255))).empty());
}

}  // namespace
}  // namespace ulf
