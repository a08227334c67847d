// Defines the defaults of a capture, for all who need or explain them.
#pragma once

#include <string>

#include "core/light_field/light_field.h"

namespace ulf::coverage {

// The threshold of the bound by the name of a quality, pixels of the coverage image (docs/coverage_bound.md).
inline constexpr double kHighThresholdPx = 7, kFastThresholdPx = 12;
// Returns the threshold of the quality "fast", or else of "high".
inline double ThresholdOf(const std::string& quality) {
  return quality == "fast" ? kFastThresholdPx : kHighThresholdPx;
}

// These belong to the light field, too.
using ulf::kCoverageWidthPx, ulf::kSubjectSize;

// The safety rectangle's share of width and height, and at most that of the subject's sphere (thesis, section
// 3.2).
inline constexpr double kRectangleShare = 0.8;

// The share of a cap that counts as all of it.
inline constexpr double kUntilShare = 0.98;

// Frames that are tracked in a row before a subject is found, or a first photograph is taken.
inline constexpr int kStableFrames = 10;

// Views that may wait for the disk.
inline constexpr int kSpoolViews = 16;

}  // namespace ulf::coverage
