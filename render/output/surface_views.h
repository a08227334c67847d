// Which photographs show the vertices of a mesh, and how well: what textures and colours of vertices
// are blended by.
//
// A view's score at a vertex is how squarely and how largely it shows the surface there, times what the proxy
// and the edge of its picture leave of it (SceneView::See()). The best few views have a share each; shares
// fall to zero where the next view takes over, so that they change smoothly along the surface.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "render/proxy/triangle_mesh.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct ViewShare {
  int view = 0;  // index into RenderScene::views
  float weight = 0;
};
// Of one vertex: sums to 1, or is empty where no view sees it.
using ViewShares = std::vector<ViewShare>;

// `scene` is over the mesh, so that it says what is hidden.
std::vector<ViewShares> SharesOfVertices(const RenderScene& scene, const TriangleMesh& mesh);

// Light of a view at a point, linear B G R on the scene's common scale, and the share of it that the
// photograph has there (0: none). `level`: of the pyramid.
cv::Vec4f LightOfView(const SceneView& view, const cv::Mat& level, const Eigen::Vector2d& img);

// Linear B G R at each vertex, of the texels that its triangles cover; where no view sees it, spread from its
// neighbours, grey where there are none.
std::vector<cv::Vec3f> ColorsOfVertices(const RenderScene& scene, const TriangleMesh& mesh,
                                        const std::vector<ViewShares>& shares);

}  // namespace ulf::render
