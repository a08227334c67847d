// Registers every recorded view against all others: matches, points, poses and, where the images determine
// it, the lens (thesis, section 6.2, which found it too expensive).
//
//   1. detect corners in every view
//   2. choose pairs of views by the poses, and match them
//   3. join the matches to tracks over all views, and triangulate
//   4. adjust poses and points
//   5. search the points in every view by their patches, and adjust again; twice
//   6. weigh the evidence for another lens; on request take it over, and begin again at 2 until it stays,
//      because what was matched and adjusted under a wrong lens speaks for that lens
//
// With a rolling shutter (RefineInput::readout_s) steps 1 to 6 treat pictures as if taken at once; a last
// adjustment models the rows (refine_rows.h). Input and output poses are those that explain all pixels of a
// picture at once.
//
// Start poses may be off by a percent and a degree: their error is measured first, and matching allows for
// it. Images leave position, orientation and scale of the whole open; the start poses give them. A view that
// fits nowhere keeps its pose and says why. The same input gives the same bytes, whatever the number of
// threads. Poses are cam_from_world in the input's units, image quantities are pixels.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <string>

#include "tracking/refine/refine_input.h"
#include "tracking/refine/refine_result.h"

namespace ulf::tracking {

struct RefineOptions {
  int features = 0;         // corners a view; 0: chosen by the number of views
  int max_side_px = 1600;   // larger pictures are reduced
  bool intrinsics = false;  // take over the lens that the evidence speaks for
  bool all_points = false;  // measure all points that the views share, not only those that poses need
  unsigned seed = 1;
  std::function<void(double share, const std::string& stage)> progress = {};
};

// Throws Error when nothing can be registered: fewer than two readable views, views that share nothing or
// were all taken from one place.
RefineResult Refine(const RefineInput& input, const RefineOptions& options = {});

}  // namespace ulf::tracking
