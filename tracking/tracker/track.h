// A frame's outcome in words, for the operator's line of progress: what is the matter and, where a camera is in the
// hand, what to do.
#pragma once

#include <string>

#include "tracking/tracker/tracker.h"

namespace ulf::tracking {

// While a map is being started, with how much of the parallax is there.
std::string InWords(const StartProgress& start, FrameSource source);

std::string InWords(const Track& track, FrameSource source);

// Of Track::focal_ratio: how far the zoom was moved, and what to do.
std::string ZoomInWords(double focal_ratio, FrameSource source);

}  // namespace ulf::tracking
