// Cuts a mesh into charts for a texture: each chart is a connected piece of the surface as one photograph
// shows it, so that a texel is about a pixel of a photograph. All charts are packed into one page (the
// texture), whose sides are powers of two.
//
// Photographs are chosen greedily by the remaining area that they show well (at half of the size at which any
// shows it, or more), so that charts are few and large. BakeTexture() chooses separately which photographs
// the light comes from. Triangles that no view sees are left out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "render/output/surface_views.h"
#include "render/proxy/triangle_mesh.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct TextureAtlas {
  TriangleMesh mesh;                        // each vertex is repeated for every chart that uses it
  std::vector<std::uint32_t> source;        // per vertex: its index in the mesh that was cut
  std::vector<Eigen::Vector2f> texel;       // per vertex: pixels of the page, (0, 0) its upper left corner
  std::vector<std::uint32_t> chart_begins;  // first triangle of each chart; charts are consecutive
  int width = 0, height = 0;                // powers of two
  double scale = 1;        // texels per pixel of a photograph; below 1 if the page is too small
  std::size_t unseen = 0;  // number of triangles that were left out

  std::size_t Charts() const { return chart_begins.size(); }
};

// Number of texels around each chart that belong to it.
inline constexpr int kChartPadding = 3;

// `scene` must have the mesh as its proxy; `most_page_px` is a power of two. Throws Error if no view sees any
// of it, or if the page is too small for its charts.
TextureAtlas MakeTextureAtlas(const RenderScene& scene, const TriangleMesh& mesh, int most_page_px = 8192);

// Bakes the texture of an atlas from the photographs: CV_8UC3, 8-bit sRGB, in the page's size. Each texel is
// blended from the views that share its triangle's corners (`shares`, by the vertices of the mesh that was
// cut), with shares that change evenly over the triangle. Texels around a chart show the surface beyond its
// edge, then repeat the nearest, so that charts do not bleed into each other; texels without light are
// filled.
cv::Mat BakeTexture(const RenderScene& scene, const TextureAtlas& atlas,
                    const std::vector<ViewShares>& shares);

}  // namespace ulf::render
