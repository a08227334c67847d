// Measures points in every view that shows them, against one picture of each.
//
// Pairwise matches join corners that were detected twice; corner detection repeats for about half of them,
// and wanders by half a pixel. With poses good to a pixel each point's reference patch (from the middle one
// of its views) is warped into every view in which it should appear and aligned to a fraction of a pixel.
// These measurements replace the detected corners.
#pragma once

#include "tracking/features/patch_alignment.h"
#include "tracking/refine/refine_scene.h"

namespace ulf::tracking {

// `per_view`: about how many points each view shows afterwards, evenly over a grid, long tracks first.
void ExtendTracks(int per_view, RefineScene& scene);

}  // namespace ulf::tracking
