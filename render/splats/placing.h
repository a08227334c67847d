// Places Gaussians on the surfaces that the views' depth maps show, in two layers (splat_shape.h). View by
// view, a cell of pixels that no Gaussian shows yet gets one: flat along the surface, as large as the cell
// there. Cells of the ground have 4 x 4 pixels, 8 x 8 where the photograph is smooth, and fewer beside edges,
// over which they would reach. Details have 1 or 2 x 2 pixels, where the photograph is not smooth. A Gaussian
// shows the pixels of all views that look at its front and whose maps agree with its place, unless they see
// the place more finely. One that no other map confirms, or that any sees through, is left out: it would
// float in the air.
//
// The rest, pixels that one view alone sees or whose maps disagree, gets the same two layers afterwards, on
// the mesh.
//
// Directions in which no Gaussian was placed, because there is no mesh either, get Gaussians on a sphere
// around everything. Coarse ones stand behind it, so that what no view shows is not black.
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
  Gaussians gaussians;     // none if there would be too many
  std::size_t around = 0;  // of them on the sphere
  std::size_t behind = 0;  // the last ones, on the backdrop; those of the sphere are before them
  double too_many = 0;     // how many times there would be more than may be; 0 if they are few enough
};

// Sets the views' `done`. Throws Error if there are none to place.
PlacedGaussians PlaceGaussians(std::vector<SplatView>& views, const PlacingOptions& options);

}  // namespace ulf::render
