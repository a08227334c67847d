// Lumigraph weights at the vertices of a triangulation of the image (Buehler et al. 2001, section 4): a
// regular grid and the projected viewpoints, Delaunay. Between vertices weights are interpolated.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "render/lumigraph_field.h"
#include "render/triangle_topology.h"

namespace ulf {

struct WeightedImageTriangulation {
  std::vector<Eigen::Vector2d> img;  // covers the image and a little more
  std::vector<std::vector<ViewWeight>> weights;
  std::vector<Triangle> triangles;
};

// How deep the proxy is at a point of the image.
using DepthAt = std::function<double(const Eigen::Vector2d& img)>;

WeightedImageTriangulation TriangulateLumigraph(const RenderScene& scene, const CameraModel& camera,
                                                const Rigid3& cam_from_world, const DepthAt& depth_at,
                                                const FieldOptions& options);

}  // namespace ulf
