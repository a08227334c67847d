// Refines views of a rolling shutter: each row has a pose of its own (tracking/estimation/rolling_shutter.h).
//
// Recorded views are seconds apart and have no neighbours in time that would tell how the camera moved. So
// each view's velocity is an unknown of the adjustment, held to the one that the capture recorded with it, or
// loosely to zero. The adjustment finds points, velocities and the poses of the middle rows. Then each view
// gets the picture's pose, which explains all its pixels as if taken at once.
#pragma once

#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/refine/refine_input.h"
#include "tracking/refine/refine_scene.h"

namespace ulf::tracking {

// Adjusts poses and points of `scene`, whose views have pictures' poses before and after, and sets
// RefineView::middle_row_from_picture. `options` must free no intrinsics. Returns the adjustment's summary;
// if it is not usable, the scene is unchanged.
BundleSummary AdjustRows(const RefineInput& input, const BundleOptions& options, RefineScene& scene);

}  // namespace ulf::tracking
