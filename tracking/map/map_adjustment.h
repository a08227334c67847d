// Bundle adjustment of a part of the map: its keyframes and points out, adjusted, and back in.
#pragma once

#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// Adjusts the keyframes `free` and all points they see (those of `held` where none is free); `held`, pinned
// keyframes and, of a part of the map, its first stay; when all is free, all together stays where it was.
// Where the world is given, the corners that keyframes saw of it take part as points that are known, and
// where they were seen from far enough apart to tell the scale they alone say where everything is.
// Observations that no longer fit are forgotten. Reads without the lock
// and takes it to write: call it from the thread that changes the map.
BundleSummary AdjustMap(const CameraModel& camera, SharedMap& shared, const std::vector<int>& free,
                        const std::vector<int>& held, const BundleOptions& options);

}  // namespace ulf::tracking
