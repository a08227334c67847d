// Places Gaussians on the surfaces that the views' depth maps show, in two layers (splat_shape.h). View by
// view, a cell of pixels that no Gaussian shows yet gets one: flat along the surface, as large as the cell
// there. Cells of the ground have 4 x 4 pixels, 8 x 8 where the photograph is smooth, and fewer beside edges,
// over which they would reach. Details have 1 or 2 x 2 pixels, where the photograph is not smooth. A Gaussian
// shows the pixels of all views whose maps agree with its place, unless they see the place more finely. One
// that more maps see through than confirm is left out: it would float in the air beside an edge. Pixels that
// remain get ground where the maps agree roughly.
//
// Directions in which no Gaussian was placed, because the maps hold nothing there that the views agree on,
// get Gaussians on a sphere around everything.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "render/splats/gaussians.h"
#include "render/splats/splat_views.h"

namespace ulf::render {

struct PlacingOptions {
  std::size_t most = 1000000;  // Gaussians, those around everything included
  bool has_background = true;  // otherwise pixels without light are seen through, and nothing is far away
  std::function<void(double share)> progress = {};
};

struct PlacedGaussians {
  Gaussians gaussians;
  std::size_t around = 0;  // the last ones, on the sphere
  int roughness = 0;       // levels of 255 by which a photograph may differ within a cell
};

// Sets the views' `done`. Returns none where no roughness keeps to the count: the views' pictures are too
// large. Throws Error if there are none to place.
std::optional<PlacedGaussians> PlaceGaussians(std::vector<SplatView>& views, const PlacingOptions& options);

}  // namespace ulf::render
