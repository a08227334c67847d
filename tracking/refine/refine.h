// Registers all recorded views against each other: finds matches, points, poses and, if the images determine
// it, the lens. The thesis (Unstructured Light Fields, MIT 2012, section 6.2) found that too expensive.
//
//   1. detect corners in every view
//   2. choose pairs of views by the poses, and match them
//   3. join the matches to tracks over all views, and triangulate
//   4. adjust poses and points
//   5. search the points in every view by their patches, and adjust again; twice
//   6. weigh the evidence for another lens (lens_evidence.h); on request take it over, and repeat from 2
//      until it stays, because what was matched and adjusted under a wrong lens speaks for that lens
//
// With a rolling shutter (RefineInput::readout_s) steps 1 to 6 treat pictures as if taken at once; a last
// adjustment models the rows (refine_rows.h). Input and output poses are those that explain all pixels of a
// picture at once.
//
// Start poses may be off by a per cent and a degree: their error is measured first, and matching allows for
// it. Images leave position, orientation and scale of the whole open; the start poses give them. A view that
// fits nowhere keeps its pose, and the result says why. The result does not depend on the number of threads.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <string>

#include "tracking/refine/refine_input.h"
#include "tracking/refine/refine_result.h"

namespace ulf::tracking {

struct RefineOptions {
  int features = 0;         // number of corners a view; 0: chosen by the number of views
  int max_side_px = 1600;   // to which the longer side of larger pictures is reduced
  bool intrinsics = false;  // takes over the lens that the evidence speaks for
  bool all_points = false;  // measures all points that the views share, not only those that poses need
  unsigned seed = 1;
  std::function<void(double share, const std::string& stage)> progress = {};  // share from 0 to 1
};

// Throws Error if nothing can be registered: fewer than two readable views, views that share nothing or were
// all taken from one place, or an adjustment that fails.
RefineResult Refine(const RefineInput& input, const RefineOptions& options = {});

}  // namespace ulf::tracking
