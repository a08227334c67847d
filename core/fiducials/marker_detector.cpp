#include "core/fiducials/marker_detector.h"

#include <algorithm>

#include "core/fiducials/aruco_calls.h"
#include "core/fiducials/board.h"

namespace ulf {
namespace {

cv::Ptr<cv::aruco::DetectorParameters> Parameters(const cv::Size& size) {
  const auto parameters = cv::makePtr<cv::aruco::DetectorParameters>();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;  // marker_corners.h
  // Two windows: the cells of a small marker, and of one that fills the image.
  parameters->adaptiveThreshWinSizeMin = 7;
  parameters->adaptiveThreshWinSizeMax = std::max(23, std::max(size.width, size.height) / 16) | 1;
  parameters->adaptiveThreshWinSizeStep = parameters->adaptiveThreshWinSizeMax - 7;
  return parameters;
}

}  // namespace

std::vector<std::pair<int, MarkerImage>> DetectMarkers(const std::string& dictionary, const cv::Mat& gray) {
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  const auto known = ArucoDictionary(DictionaryNumber(dictionary));
  cv::aruco::detectMarkers(gray, known, corners, ids, Parameters(gray.size()));
  std::vector<std::pair<int, MarkerImage>> found;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    MarkerImage img;  // OpenCV counts pixel centres as integers
    for (std::size_t k = 0; k < 4; ++k) img[k] = {corners[i][k].x + 0.5, corners[i][k].y + 0.5};
    found.emplace_back(ids[i], RefinedBySides(gray, img, known->markerSize + 2));
  }
  return found;
}

}  // namespace ulf
