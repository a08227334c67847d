// Single markers in an image, by the dictionary that they are of.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/fiducials/marker_corners.h"

namespace ulf {

// All markers of the dictionary, sub-pixel, in no order; `gray` CV_8UC1.
std::vector<std::pair<int, MarkerImage>> DetectMarkers(const std::string& dictionary, const cv::Mat& gray);

}  // namespace ulf
