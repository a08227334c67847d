// Registers every recorded view against all others: matches, points, poses and, where the images determine
// it, the lens (thesis, section 6.2, which found it too expensive).
//
//   1. detect corners in every view
//   2. choose pairs of views by the poses, and match them
//   3. join the matches to tracks over all views, and triangulate
//   4. adjust poses and points
//   5. search the points in every view by their patches, and adjust again; twice
//   6. weigh the evidence for another lens; on request take it over, and begin again at 2 until it stays: what was matched
//      and adjusted under a wrong lens speaks for it
//
// With a rolling shutter (RefineInput::readout_s) steps 1 to 6 take pictures as if taken at once; a last adjustment knows
// the rows (refine_rows.h). Poses that go in and out are the pictures', those that explain all pixels of one at once.
//
// Start poses may be off by a percent and a degree: their error is measured first, and matching allows for
// it. Images leave position, orientation and scale of the whole open; the start poses give them. A view that
// fits nowhere keeps its pose and says why. The same input gives the same bytes, whatever the number of
// threads. Poses are cam_from_world in the input's units, image quantities are pixels.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/image.h"
#include "core/light_field/light_field.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/estimation/lens_evidence.h"
#include "tracking/estimation/rolling_shutter.h"
#include "tracking/refine/refine_input.h"
#include "tracking/refine/refine_result.h"

namespace ulf::tracking {

struct RefineOptions {
  int features = 0;         // corners a view; 0: by the number of views
  int max_side_px = 1600;   // larger pictures are reduced
  bool intrinsics = false;  // take over the lens that the evidence speaks for
  bool all_points = false;  // measure all points that the views share, not only those that poses need
  unsigned seed = 1;
  std::function<void(double share, const std::string& stage)> progress = {};

  // Corners of each of few views (kFewViews), which need more, and of each of many; points a view of few, of
  // many, and while poses are rough. More cost time. Guessed.
  int corners_of_few = 4000, corners = 1500;
  int per_view_of_few = 1500, per_view = 500, per_view_roughly = 400;
  double most_error_px = 40;  // of start poses: assumed where hardly anything matches. Guessed
  int min_view_points = 20;   // a view with fewer points is not registered. Guessed
  int min_pairs = 10;         // whose matches the views share at least, to be compared. Guessed
  // Gates of triangulation: times the start poses' error and at least so much; times the error after a first
  // adjustment. Wider ones let in wrong matches, narrower ones lose right ones. Guessed.
  double gate_errors = 6, least_gate_px = 4, repeated_gate_errors = 8;
  // Iterations of the first adjustment under good and under bad start poses, of the first with poses that
  // guide, and of all later ones. Guessed.
  int guided_iterations = 10, unguided_iterations = 60, repeated_iterations = 30, iterations = 12;
  // Relative change of the cost that ends all adjustments but the last ones, for which they are starts and
  // need not reach their minimum. Guessed.
  double rough_tolerance = 1e-4;
  // With `intrinsics`: a step of the lens that moves no point of the reduced image by more needs no other pass; passes, at
  // most. Guessed.
  double settled_lens_px = 0.5;
  int most_passes = 6;
  // For settled poses, in units of the errors' own scale: the width of Cauchy's loss (measured:
  // docs/tracking_measured.md, "Cauchy's loss"), and the gate, beyond which 0.03 % of normal errors lie.
  double cauchy_scales = 2, gate_scales = 4;
  // A view registered again: best descriptor distance / second best of a match. Guessed.
  double max_ratio = 0.85;
  // A view that keeps a smaller share of its observations is contradicted by most of them.
  double contradicted_share = 0.5;
};

// Throws Error when nothing can be registered: fewer than two readable views, views that share nothing or
// were all taken from one place.
RefineResult Refine(const RefineInput& input, const RefineOptions& options = {});

}  // namespace ulf::tracking
