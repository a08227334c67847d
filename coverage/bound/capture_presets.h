// Defines the defaults of a capture, for all who need or explain them.
#pragma once

#include <string>

#include "core/light_field/light_field.h"

namespace ulf::coverage {

// The thresholds of the bound for a capture's qualities "high" and "fast", pixels of the coverage image
// (docs/coverage_bound.md).
inline constexpr double kHighThresholdPx = 7, kFastThresholdPx = 12;
// Returns the threshold of "fast", and for every other text that of "high".
inline double ThresholdOf(const std::string& quality) {
  return quality == "fast" ? kFastThresholdPx : kHighThresholdPx;
}

// These belong to the light field, too.
using ulf::kCoverageWidthPx, ulf::kSubjectSize;

// The share of the picture's width and height that the safety rectangle has, in which the sphere's image must
// stay (thesis, section 3.2).
inline constexpr double kRectangleShare = 0.8;

// The share of a cap that counts as all of it.
inline constexpr double kUntilShare = 0.98;

// How many frames must be tracked in a row before a subject is found, or a first photograph is taken.
inline constexpr int kStableFrames = 10;

// How many views may wait for the disk.
inline constexpr int kSpoolViews = 16;

}  // namespace ulf::coverage
