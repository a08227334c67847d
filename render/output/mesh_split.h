// Meshes made coarser and finer.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

// A coarser mesh: the vertices in each cell of a grid become one (Rossignac and Borrel 1993), at the place nearest to the
// planes of their triangles (Lindstrom 2000). Needs no manifold. With at most `most_triangles`, as many as one size of cell gives; the mesh itself where it has no more.
TriangleMesh Clustered(const TriangleMesh& mesh, std::size_t most_triangles);

// A finer mesh of the same surface: edges longer than `most_slope` times the distance of their middle to the nearest view
// are halved until none is, or until there are `most_triangles`. Triangles that share an edge split it alike.
TriangleMesh Split(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& view_centers,
                   double most_slope, std::size_t most_triangles);

}  // namespace ulf::render
