// Loop subdivision of weights (thesis, section 5.3; Loop 1987 with Warren's weights).
//
// Each vertex of the mesh starts with weight 1 for itself. A level splits every triangle into four and gives
// each vertex a mean of the old weights:
//
//   interior vertex of valence n   1 - n b its own, b each neighbour; b = 3/16 for n = 3, else 3/(8 n)
//   interior edge's midpoint       3/8, 3/8 the ends, 1/8, 1/8 the opposite corners
//   boundary vertex                1 its own
//   boundary edge's midpoint       1/2, 1/2 the ends
//
// Loop gives a boundary vertex 3/4, 1/8, 1/8. Here it keeps its own weight, because the boundary's weights
// continue outside the hull, where a wider mean only blurs. The geometry is not smoothed: new vertices are
// the midpoints of edges, so that perspective stays exact. At every level weights are not negative, sum to
// one, and reach no farther than the 2-ring.
//
// Loop assumes that the edges are chosen. These are Delaunay's: if four viewpoints lie on a circle, as on
// every grid, the diagonal between two of them is arbitrary, and 3/8, 3/8, 1/8, 1/8 would prefer those two.
// Therefore the first level's shares of the two opposite corners grow from 1/8, if the angles that face the
// edge sum to 120 degrees as in a regular mesh, to 1/4 at 180 degrees, where both diagonals are Delaunay's.
// The weights then do not depend on the diagonal, and do not jump when a moving viewpoint changes it
// (docs/rendering.md, Quality: 0.2 dB on shop_grid_even).
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "render/viewpoints/triangle_topology.h"

namespace ulf::render {

// Pairs of (vertex of the original mesh, weight), in ascending order of vertices.
using SparseWeights = std::vector<std::pair<int, double>>;

struct SubdividedMesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3d> outward;  // per vertex: interpolated along boundary edges, zero inside
  std::vector<SparseWeights> weights;
  std::vector<Triangle> triangles;
  std::vector<int> parent;  // per triangle: the original triangle that contains it
};

inline constexpr int kFinestLevel = 3;

enum class SubdivisionRules {
  kDelaunay,  // as above
  kLoop       // as published: 3/4, 1/8, 1/8 at boundary vertices, 3/8, 3/8, 1/8, 1/8 on every interior edge
};

// Subdivides `levels` times, at most kFinestLevel times; 0 leaves each vertex its own weight (piecewise
// linear weights). `triangles` must be Delaunay's. `outward` has a vector for each vertex, zero inside.
SubdividedMesh SubdivideWeights(const std::vector<Eigen::Vector3d>& positions,
                                const std::vector<Eigen::Vector3d>& outward,
                                const std::vector<Triangle>& triangles, int levels,
                                SubdivisionRules rules = SubdivisionRules::kDelaunay);

}  // namespace ulf::render
