// Adjusts keyframes and points of the map (bundle_adjustment.h) in a copy, and writes them back.
#pragma once

#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// Returns a copy of all living keyframes and points, for checks that change nothing in the map.
BundleProblem ProblemOf(const Map& map);

// Adjusts the keyframes `free` and all points that they see (without any, the points of `held`), and removes
// observations that do not fit. `held`, pinned keyframes and the first keyframe of each part of the map stay;
// if none is held or pinned, all keyframes of a part are moved back afterwards so that together they stay
// where they were. In a given world the corners that keyframes saw take part as known points; if they were
// seen from far enough apart to determine the scale, they alone hold the map. `rows_too` also estimates the
// velocities of keyframes with a rolling shutter that turned fast: only for a whole part, because it takes
// motion in several directions to separate them from the lens. Reads without the map's lock and takes it to
// write: only the map's owner may call it. A result that is not usable changes nothing.
BundleSummary AdjustMap(const CameraModel& camera, OwnedMap& owned, const std::vector<int>& free,
                        const std::vector<int>& held, const BundleOptions& options, bool rows_too = false);

// Adjusts all keyframes and points together with the lens (options.free). A usable result changes `lens`.
BundleSummary AdjustMapAndLens(CameraModel& lens, OwnedMap& owned, const BundleOptions& options);

}  // namespace ulf::tracking
