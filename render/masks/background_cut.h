// Which pixels of a picture stand before a known still background: the cut of least cost through the picture (after
// Sun, Zhang, Tang and Shum 2006, "Background Cut"). A pixel costs by how unlike the background it is, a border where
// it does not run along an edge; edges that the background has itself count less.
#pragma once

#include <opencv2/core.hpp>

#include "render/masks/still_background.h"

namespace ulf::render {

// What is known beforehand: CV_8U.
enum class CutLabel : std::uint8_t { kUnknown = 0, kStill = 1, kTurning = 2 };

struct CutOptions {
  // All guessed, as logarithms of odds.
  float undecided =
      4.5f;         // the cost of turning: a pixel three deviations off the background is as likely either
  float most = 14;  // the cost of being still is no larger
  float unknown_leans = 2;  // towards turning, where there is no background
  float border = 7;         // of a border through an even place
  float wobble_px = 0.3f;   // of the camera: so much of the background's gradient is no difference
};

// CV_8U, 255: turning. `leans`: CV_32F, added to the cost of being still; empty: 0.
cv::Mat CutFromBackground(const cv::Mat& picture, const StillBackground& background, const cv::Mat& labels,
                          const cv::Mat& leans, const CutOptions& options = {});

}  // namespace ulf::render
