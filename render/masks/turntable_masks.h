// Masks for a light field whose subject turned before a camera that stood: what stands still is left out.
//
// 1. The poses tell the turntable's axis and where the camera stood while (core/geometry/turn_axis.h).
// 2. Of each stand's views the still background is learnt (still_background.h). The board is known to turn.
// 3. Each view is cut from its background (background_cut.h).
// 4. What all views together leave of the subject is a hull (silhouette_hull.h). Each view is cut again:
//    outside the hull nothing turns, and well inside it nothing stands still. Views that were taken while the
//    camera was moved, which have no background, are the hull's outline.
//
// Limits: a subject that is round about the axis and of one colour looks still; shadows that turn with the
// subject on what stands still are taken for the subject, as far as the hull allows. The camera may wobble
// by a few pixels.
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
  int size_px = 640;  // longer side of the pictures that are compared; masks have the photographs' size
};

struct Stand {
  std::vector<int> views;  // by index into LightField::views
  double turned = 0;       // radians: the sum of the turns between them
  double shift_px = 0;     // the largest of a view against the background, at the size that is compared
};

struct TurntableMasks {
  std::map<int, cv::Mat> masks;  // by View::id: CV_8UC1 of the photograph's size, 255: turns, 0: stands still
  TurnAxis axis;
  std::vector<Stand> stands;  // whose background was learnt
  int views_between = 0;      // without a background: the hull's outline is their mask
  double turning_share = 0;   // of the pixels, on average
};

// Throws Error where the poses do not turn about an axis, where no stand has enough views, or where nothing
// moves in the pictures.
TurntableMasks MakeTurntableMasks(const LightField& light_field, const TurntableMaskOptions& options = {},
                                  Progress* progress = nullptr);

// Makes the masks of all views and writes them into the light field, with a progress line. Throws as
// MakeTurntableMasks() and LightFieldWriter do; then the light field is as it was.
TurntableMasks WriteTurntableMasks(const std::filesystem::path& dir,
                                   const TurntableMaskOptions& options = {});

}  // namespace ulf::render
