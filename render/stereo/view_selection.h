// Selects the views that get a depth map, and the other views with which each of them is compared.
#pragma once

#include <vector>

#include "core/geometry/angles.h"
#include "core/light_field/light_field.h"
#include "render/stereo/stereo_view.h"

namespace ulf::render {

// Returns up to `count` other views, best first: with a good parallax, a shared image, and spread
// around the view. The list may be empty.
std::vector<int> NeighboursOf(int view, const std::vector<StereoView>& views, const Subject& subject,
                              int count);

// Returns up to `count` views, spread as evenly as possible; all if there are no more. Ascending.
std::vector<int> SpreadViews(const std::vector<StereoView>& views, const Subject& subject, int count);

}  // namespace ulf::render
