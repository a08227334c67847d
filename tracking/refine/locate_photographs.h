// Finds where photographs were taken whose poses nobody knows, from recorded views of the same scene: one
// camera after the other, as structure from motion does (Schönberger and Frahm 2016, section 4.2).
//
//   1. match the views that have poses, and triangulate points
//   2. match every photograph with every one of these views by descriptors alone; the points that its best
//      views show give its pose (P3P)
//   3. photographs that were found count as views with poses: again from 1, until no other one is found
//
// So a group of photographs is found from the one that shows something of the views. Poses are good enough to
// begin refining from (refine.h), which also finds out whether other views confirm them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/rigid3.h"
#include "tracking/refine/refine_input.h"

namespace ulf::tracking {

struct LocateOptions {
  int max_side_px = 1600;  // larger pictures are reduced
  unsigned seed = 1;
};

struct LocatedPhotograph {
  std::optional<Rigid3> cam_from_world;
  int points = 0;   // that agree on it
  std::string why;  // there is none
};

// Returns the poses of input.views from `first_unposed` on, whose own poses are ignored. Throws Error as
// Refine() does where the views before share too little.
std::vector<LocatedPhotograph> LocatePhotographs(
    const RefineInput& input, std::size_t first_unposed, const LocateOptions& options = {},
    const std::function<void(double share, const std::string& stage)>& progress = {});

}  // namespace ulf::tracking
