// Finds single ArUco markers of one dictionary in an image.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/fiducials/marker_corners.h"

namespace ulf {

// All markers with their numbers, in no particular order, corners refined (marker_corners.h). `gray`:
// CV_8UC1. Throws Refusal for a dictionary that does not exist.
std::vector<std::pair<int, MarkerImage>> DetectMarkers(const std::string& dictionary, const cv::Mat& gray);

}  // namespace ulf
