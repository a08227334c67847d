// Separates a picture from a known still background by a minimum cut (after Sun, Zhang, Tang and Shum 2006,
// "Background Cut"). A pixel costs by how unlike the background it is, a border if it does not run along an
// edge; edges that the background has itself count less.
#pragma once

#include <opencv2/core.hpp>

#include "render/masks/still_background.h"

namespace ulf::render {

// Prior knowledge about a pixel, CV_8U.
enum class CutLabel : std::uint8_t { kUnknown = 0, kStill = 1, kTurning = 2 };

// Returns CV_8U, 255 where turning. `leans`, CV_32F, is added to the cost of being still; empty means 0.
cv::Mat CutFromBackground(const cv::Mat& picture, const StillBackground& background, const cv::Mat& labels,
                          const cv::Mat& leans);

}  // namespace ulf::render
