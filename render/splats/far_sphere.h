// Gaussians for what lies beyond the depth maps: the sky, a far background, walls on which the views find
// nothing to match. They stand on a sphere around all others, where views show pixels without a Gaussian.
#pragma once

#include <cstddef>
#include <vector>

#include "render/splats/gaussians.h"
#include "render/splats/splat_views.h"

namespace ulf::render {

// Adds Gaussians until there are at most `most`, and returns how many; they are coarser where they would be
// more.
std::size_t AddFarSphere(const std::vector<SplatView>& views, std::size_t most, Gaussians& gaussians);

// Adds coarse Gaussians behind all others, in the directions that views show and some degrees beyond, as far
// as there may be `most`, and returns how many. They give places that no view shows about the right colour.
std::size_t AddBackdrop(const std::vector<SplatView>& views, std::size_t most, Gaussians& gaussians);

}  // namespace ulf::render
