// A frame's outcome in words, for the operator's line of progress.
#pragma once

#include <string>

#include "tracking/tracker/tracker.h"

namespace ulf::tracking {

// While a map is being started: what to do, and how much of the parallax is there.
std::string InWords(const StartProgress& start);

std::string InWords(const Track& track);

// Of Track::focal_ratio: how far the zoom was moved, and what to do.
std::string ZoomInWords(double focal_ratio);

}  // namespace ulf::tracking
