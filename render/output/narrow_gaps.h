// Slivers of a picture that no photograph shows, mostly along its border, for displays and comparisons: the colour beside
// them instead of black. What is wider stays black, since nobody knows what is there.
#pragma once

#include <opencv2/core.hpp>

namespace ulf::render {

// Of the longer side: a gap with a pixel farther than this from what is drawn is wide. Guessed.
inline constexpr double kNarrowGapShare = 0.03;

// `linear` CV_32FC3, `drawn` CV_8U (Rendering). The same picture where everything is drawn.
cv::Mat WithNarrowGapsClosed(const cv::Mat& linear, const cv::Mat& drawn);

}  // namespace ulf::render
