// Selects the views that get a depth map, and the other views with which each of them is compared.
#pragma once

#include <vector>

#include "core/geometry/angles.h"
#include "core/light_field/light_field.h"
#include "render/stereo/stereo_view.h"

namespace ulf::render {

struct NeighbourOptions {
  int count = 8;
  // The score falls below this angle to a chosen view, over the wanted parallax, down to `least_of_score`.
  // Guessed.
  double spread = 0.5, least_of_score = 0.1;
};

// Returns up to options.count other views, best first: with a good parallax, a shared image, and spread
// around the view. The list may be empty.
std::vector<int> NeighboursOf(int view, const std::vector<StereoView>& views, const Subject& subject,
                              const NeighbourOptions& options);

// Returns up to `count` views, spread as evenly as possible; all if there are no more. Ascending.
std::vector<int> SpreadViews(const std::vector<StereoView>& views, const Subject& subject, int count);

}  // namespace ulf::render
