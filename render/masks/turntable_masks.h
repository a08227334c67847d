// Makes masks that exclude the still background of a light field whose subject turned before the camera.
//
// 1. The poses give the turntable's axis and the camera's stands: times in which it stayed in one place
//    (core/geometry/turn_axis.h).
// 2. The views of each stand give its still background (still_background.h). The board on the table is known
//    to turn.
// 3. Each view is cut from its background (background_cut.h).
// 4. The masks of all views give the subject's hull (silhouette_hull.h). Each view is cut again: outside the
//    hull nothing turns, and well inside it hardly anything stands still. Views without a background, taken
//    between stands or in one of fewer than eight views, get the hull's outline.
//
// Limits: a subject that is round about the axis and of one colour looks still; shadows that turn with the
// subject are taken for the subject, as far as the hull allows. The camera may wobble by a few pixels.
#pragma once

#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/progress.h"
#include "core/geometry/turn_axis.h"
#include "core/light_field/light_field.h"

namespace ulf::render {

struct TurntableMaskOptions {
  int size_px = 640;  // px, longer side of the compared pictures; masks have the photographs' size
};

struct Stand {
  std::vector<int> views;  // indices into LightField::views
  double turned = 0;       // radians: the sum of the rotations from view to view
  double shift_px = 0;     // px at the compared size: the largest shift of a view against the background
};

struct TurntableMasks {
  std::map<int, cv::Mat> masks;  // by View::id: CV_8UC1 of the photograph's size, 255: subject, 0: background
  TurnAxis axis;
  std::vector<Stand> stands;  // stands with a known background
  int views_between = 0;      // views without a background: their mask is the hull's outline
  double turning_share = 0;   // mean share of subject pixels
};

// Throws Error if the poses do not turn about an axis, if no stand has eight views, or if nothing turns in
// most of the pictures.
TurntableMasks MakeTurntableMasks(const LightField& light_field, const TurntableMaskOptions& options = {},
                                  Progress* progress = nullptr);

// Makes the masks of all views and writes them into the light field, with a progress line. Throws as
// MakeTurntableMasks() and LightFieldWriter do; then the light field is as it was.
TurntableMasks WriteTurntableMasks(const std::filesystem::path& dir,
                                   const TurntableMaskOptions& options = {});

}  // namespace ulf::render
