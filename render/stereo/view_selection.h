// Which views get a depth map, and with which other views each of them is compared.
#pragma once

#include <vector>

#include "core/geometry/angles.h"
#include "core/light_field/light_field.h"
#include "render/stereo/stereo_view.h"

namespace ulf::render {

struct NeighbourOptions {
  int count = 8;
  // Angle to a chosen view, over the wanted parallax, below which the score falls; and how far it falls.
  // Guessed.
  double spread = 0.5, least_of_score = 0.1;
};

// Up to options.count other views, best first: with a good parallax, a shared image, and spread around the
// view. May be empty.
std::vector<int> NeighboursOf(int view, const std::vector<StereoView>& views, const Subject& subject,
                              const NeighbourOptions& options);

// Up to `count` views, spread as evenly as possible; all where there are no more. Ascending.
std::vector<int> SpreadViews(const std::vector<StereoView>& views, const Subject& subject, int count);

}  // namespace ulf::render
