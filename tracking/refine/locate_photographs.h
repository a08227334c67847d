// Finds where photographs without poses were taken, from recorded views of the same scene: one camera after
// the other, as structure from motion does (Schönberger and Frahm 2016, section 4.2).
//
//   1. match the views that have poses, and triangulate points
//   2. match every photograph with every one of these views by descriptors alone; the points that its best
//      views show give its pose (P3P)
//   3. count photographs that were found as views with poses, and repeat from 1 until no other one is found
//
// So a group of photographs is found from the one that shows something of the views. The poses are good
// enough as the start of refining (refine.h), which also finds out whether other views confirm them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/rigid3.h"
#include "tracking/refine/refine_input.h"

namespace ulf::tracking {

struct LocateOptions {
  int max_side_px = 1600;  // to which the longer side of larger pictures is reduced
  unsigned seed = 1;
};

struct LocatedPhotograph {
  std::optional<Rigid3> cam_from_world;
  int points = 0;   // number of points that agree on the pose
  std::string why;  // there is no pose
};

// Returns the poses of input.views from index `first_unposed` on; those in the input are ignored. Throws
// Error if there are fewer than two views before.
std::vector<LocatedPhotograph> LocatePhotographs(
    const RefineInput& input, std::size_t first_unposed, const LocateOptions& options = {},
    const std::function<void(double share, const std::string& stage)>& progress = {});

}  // namespace ulf::tracking
