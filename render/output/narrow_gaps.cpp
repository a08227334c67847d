#include "render/output/narrow_gaps.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace ulf::render {

cv::Mat WithNarrowGapsClosed(const cv::Mat& linear, const cv::Mat& drawn) {
  const int known = cv::countNonZero(drawn);
  if (known == 0 || known == static_cast<int>(drawn.total())) return linear;
  cv::Mat distance, nearest;
  cv::distanceTransform(drawn == 0, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<cv::Vec3f> color_of(static_cast<std::size_t>(known) + 1);
  for (int y = 0; y < drawn.rows; ++y)
    for (int x = 0; x < drawn.cols; ++x)
      if (drawn.at<std::uint8_t>(y, x))
        color_of[static_cast<std::size_t>(nearest.at<int>(y, x))] = linear.at<cv::Vec3f>(y, x);
  const float most = static_cast<float>(kNarrowGapShare * std::max(drawn.cols, drawn.rows));
  cv::Mat gap_of;
  const int gaps = cv::connectedComponents(drawn == 0, gap_of, 8, CV_32S);
  std::vector<bool> is_narrow(static_cast<std::size_t>(gaps), true);
  for (int y = 0; y < drawn.rows; ++y)
    for (int x = 0; x < drawn.cols; ++x)
      if (distance.at<float>(y, x) > most) is_narrow[static_cast<std::size_t>(gap_of.at<int>(y, x))] = false;
  cv::Mat closed = linear.clone();
  for (int y = 0; y < drawn.rows; ++y)
    for (int x = 0; x < drawn.cols; ++x)
      if (!drawn.at<std::uint8_t>(y, x) && is_narrow[static_cast<std::size_t>(gap_of.at<int>(y, x))])
        closed.at<cv::Vec3f>(y, x) = color_of[static_cast<std::size_t>(nearest.at<int>(y, x))];
  return closed;
}

}  // namespace ulf::render
