// The texture of an atlas, baked from the photographs.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "render/output/surface_views.h"
#include "render/output/texture_atlas.h"

namespace ulf::render {

// CV_8UC3, 8-bit sRGB, in the page's size. Each texel is blended from the views that share its triangle's corners
// (`shares`, by the vertices of the mesh that was cut), with shares that change evenly over the triangle, at the place
// of the surface that it shows. Texels around a chart show the surface beyond its edge, then repeat the nearest, so that
// neighbouring charts do not bleed into it; where photographs have no light, neighbours fill in.
cv::Mat BakeTexture(const RenderScene& scene, const TextureAtlas& atlas,
                    const std::vector<ViewShares>& shares);

}  // namespace ulf::render
