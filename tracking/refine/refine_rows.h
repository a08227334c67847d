// Refines views of a rolling shutter: each row has a pose of its own (tracking/estimation/rolling_shutter.h).
//
// Recorded views are seconds apart and have no neighbours in time that would say how the camera moved. So
// each view's velocity is an unknown of the adjustment, held to the one that the capture recorded with it; a
// view without one is held to standing still, loosely. What the adjustment finds are points, the poses of the
// middle rows and velocities. A view's pose is then, as everywhere in a light field, the picture's: the one
// that explains all its pixels as if they had been taken at once.
#pragma once

#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/refine/refine_input.h"
#include "tracking/refine/refine_scene.h"

namespace ulf::tracking {

// Adjusts poses, points and velocities of `scene`, whose views' poses are the pictures', before and after.
// Returns the adjustment's result; where it is not usable, the scene is unchanged. `options` are those of an
// adjustment without rows.
BundleSummary AdjustRows(const RefineInput& input, const BundleOptions& options, RefineScene& scene);

}  // namespace ulf::tracking
