// Bundle-adjusts the map or a part of it: copies keyframes and points out, adjusts them, and writes them
// back. Lengths are in the world's unit, image points in pixels.
#pragma once

#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// Returns a copy of all living keyframes and points, for checks that change nothing in the map.
BundleProblem ProblemOf(const Map& map);

// Adjusts the keyframes `free` and all points they see (the points of `held` where none is free). `held`,
// pinned keyframes and, in an adjustment of a part, the map's first keyframe stay; when everything is free,
// the keyframes together stay where they were. In a given world the corners that keyframes saw take part as
// known points; where they were seen from far enough apart to determine the scale, they alone hold the map.
// `rows_too` estimates the velocities of keyframes that turned fast as well: only with the whole map, since
// it takes motion in several directions to separate them from the lens. Removes observations that no longer
// fit. Reads without the map's lock and takes it to write: the map's owner calls it.
BundleSummary AdjustMap(const CameraModel& camera, OwnedMap& owned, const std::vector<int>& free,
                        const std::vector<int>& held, const BundleOptions& options, bool rows_too = false);

// Adjusts all keyframes and points with the lens (options.free). A usable result changes `lens`.
BundleSummary AdjustMapAndLens(CameraModel& lens, OwnedMap& owned, const BundleOptions& options);

}  // namespace ulf::tracking
