// Points in every view that shows them, measured against one picture of each.
//
// Pairwise matches join corners that were detected twice; corner detection repeats for about half of them,
// and wanders by half a pixel. With poses good to a pixel each point's reference patch (from the middle one
// of its views) is warped into every view in which it should appear and aligned to a fraction of a pixel;
// these measurements replace the detected corners.
#pragma once

#include "tracking/refine/refine_scene.h"

namespace ulf::tracking {

struct ExtensionOptions {
  int per_view = 500;               // about so many points a view, evenly over the image, long tracks first
  double max_view_change_deg = 45;  // from where the reference patch was taken
  double max_shift = 2.5;           // of the patch from where the pose expects it, pixels of its level
};

void ExtendTracks(const ExtensionOptions& options, RefineScene& scene);

}  // namespace ulf::tracking
