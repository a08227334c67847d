// Separates a turning subject from a known still background by a minimum cut (after Sun, Zhang, Tang and Shum
// 2006, "Background Cut"). A pixel labelled still costs the more, the less it looks like the background; a
// border between the labels costs less along an edge of the picture that the background does not have.
#pragma once

#include <opencv2/core.hpp>

#include "render/masks/still_background.h"

namespace ulf::render {

// Says what is known of a pixel before the cut.
enum class CutLabel : std::uint8_t { kUnknown = 0, kStill = 1, kTurning = 2 };

// Returns CV_8U, 255 where turning. `picture` is CV_8UC3; `labels` holds a CutLabel for each pixel (CV_8U).
// `leans` (CV_32F; empty: 0) is added to the cost of a still pixel: log odds, positive towards turning.
cv::Mat CutFromBackground(const cv::Mat& picture, const StillBackground& background, const cv::Mat& labels,
                          const cv::Mat& leans);

}  // namespace ulf::render
