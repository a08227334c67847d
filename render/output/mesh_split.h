// Meshes made finer.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

// A finer mesh of the same surface: edges longer than `most_slope` times the distance of their middle to the nearest view
// are halved until none is, or until there are `most_triangles`. Triangles that share an edge split it alike.
TriangleMesh Split(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& view_centers,
                   double most_slope, std::size_t most_triangles);

}  // namespace ulf::render
