// Finds neighbours in a triangle mesh. Triangles are counter-clockwise as seen from outside. The mesh must be
// manifold: at most two triangles share an edge, and the triangles at a vertex are one fan, in which each
// shares an edge with the next (SplitPinches() makes it so).
#pragma once

#include <array>
#include <vector>

namespace ulf::render {

using Triangle = std::array<int, 3>;  // indices of vertices

struct MeshEdge {
  int from = -1, to = -1;               // in the direction of its first triangle
  std::array<int, 2> triangle{-1, -1};  // the second is -1 on the boundary
  std::array<int, 2> opposite{-1, -1};  // each triangle's corner that is not on the edge; -1 without one
  bool OnBoundary() const { return triangle[1] < 0; }
};

struct TriangleTopology {
  std::vector<MeshEdge> edges;
  std::vector<std::array<int, 3>> edges_of_triangle;  // edge k joins corners k and (k + 1) % 3
  std::vector<std::vector<int>> neighbours;           // per vertex, ascending
  // Per vertex, the previous and the next boundary vertex (mesh on the left); -1 and -1 inside.
  std::vector<std::array<int, 2>> boundary_neighbours;

  bool OnBoundary(int vertex) const { return boundary_neighbours[static_cast<std::size_t>(vertex)][0] >= 0; }
};

TriangleTopology MakeTopology(int vertex_count, const std::vector<Triangle>& triangles);

// Gives all but one of several fans of triangles that touch in one vertex (a pinch) a copy of it in
// `triangles`. Returns the old vertex of each copy; copies are numbered from `vertex_count` on.
std::vector<int> SplitPinches(int vertex_count, std::vector<Triangle>& triangles);

}  // namespace ulf::render
