// Determines which photographs show a mesh's vertices, and how well, to blend textures and vertex colours.
//
// A view's score at a vertex is how squarely and how largely it shows the surface there, times how well it
// sees the vertex past the proxy and the edge of its picture (the feather of SceneView::ProjectVisible()).
// The best few views have shares, which fall to zero where the next view takes over.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "render/proxy/triangle_mesh.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct ViewShare {
  int view = 0;  // index into RenderScene::views
  float weight = 0;
};
// The shares at one vertex sum to 1, or are empty if no view sees it.
using ViewShares = std::vector<ViewShare>;

// `scene` must have the mesh as its proxy, which determines occlusion.
std::vector<ViewShares> SharesOfVertices(const RenderScene& scene, const TriangleMesh& mesh);

// Returns linear B G R at each vertex, averaged over about an edge of the mesh; for a vertex that no view
// sees, the mean of its neighbours, or grey without any.
std::vector<cv::Vec3f> ColorsOfVertices(const RenderScene& scene, const TriangleMesh& mesh,
                                        const std::vector<ViewShares>& shares);

}  // namespace ulf::render
