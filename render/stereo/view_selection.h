// Selects the views that get a depth map, and the other views with which each of them is compared.
#pragma once

#include <vector>

#include "core/geometry/angles.h"
#include "core/light_field/light_field.h"
#include "render/stereo/stereo_view.h"

namespace ulf::render {

// Returns the view's distance from the subject's centre, but at least half the subject's radius: where the
// subject stands for a place, a view may stand in the middle of it.
double DistanceFrom(const Subject& subject, const StereoView& view);

// Returns the indices of up to `count` other views, the best first: with a parallax near 8 degrees, a large
// part of the image in common, and spread around the view. There may be none.
std::vector<int> NeighboursOf(int view, const std::vector<StereoView>& views, const Subject& subject,
                              int count);

// Returns the indices of up to `count` views, ascending, spread evenly in the places where they stand and in
// the directions in which they look; of all if there are no more.
std::vector<int> SpreadViews(const std::vector<StereoView>& views, const Subject& subject, int count);

}  // namespace ulf::render
