// Which pixels of a picture stand before a known still background: the cut of least cost through the picture
// (after Sun, Zhang, Tang and Shum 2006, "Background Cut"). A pixel costs by how unlike the background it is,
// a border where it does not run along an edge; edges that the background has itself count less.
#pragma once

#include <opencv2/core.hpp>

#include "render/masks/still_background.h"

namespace ulf::render {

// What is known beforehand: CV_8U.
enum class CutLabel : std::uint8_t { kUnknown = 0, kStill = 1, kTurning = 2 };

// CV_8U, 255: turning. `leans`: CV_32F, added to the cost of being still; empty: 0.
cv::Mat CutFromBackground(const cv::Mat& picture, const StillBackground& background, const cv::Mat& labels,
                          const cv::Mat& leans);

}  // namespace ulf::render
