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

struct ExtensionOptions {
  int per_view = 500;                    // about so many points a view, evenly over a grid, long tracks first
  int columns = 16, rows = 12;           // of that grid: more cells spread the points more evenly. Guessed
  double max_view_change_deg = 45;       // from where the reference patch was taken. Guessed
  double nearest = 0.4, farthest = 2.5;  // distances, of the reference view's. Guessed
  double border_px = 12;                 // at the image's edge, without room for a patch
  // Patches tried for one that is found, in a cell that is not full. Guessed.
  int tries = 3;
  PatchAlignmentOptions alignment = {};
  // A patch without a corner match must look more alike than one with it. Guessed.
  double min_new_correlation = 0.9;
};

void ExtendTracks(const ExtensionOptions& options, RefineScene& scene);

}  // namespace ulf::tracking
