// Loop subdivision of weights (thesis, section 5.3; Loop 1987 with Warren's weights).
//
// Each vertex of the mesh starts with weight 1 for itself. A level splits every triangle in four and gives
// each new vertex a mean of old weights: interior vertex of valence n (1 - n b) own + b each neighbour, b =
// 3/16 for n = 3, else 3/(8 n); interior edge 3/8, 3/8, 1/8, 1/8; boundary edge 1/2, 1/2. A boundary vertex
// keeps its own weight, where Loop has 3/4, 1/8, 1/8: the boundary's weights go on past the hull, where
// nothing is to be smoothed and views farther off only blur. The geometry is not smoothed: new vertices are
// the edges' midpoints, so perspective stays exact. At every level weights are non-negative, sum to one, and
// reach no farther than the 2-ring.
//
// Loop takes the edges as given. Ours are Delaunay's: where four viewpoints lie on a circle, as on every
// grid, it is chance which diagonal joins two of them, and 3/8, 3/8, 1/8, 1/8 would prefer those two. So the
// first level's shares of the two opposite corners grow from 1/8, where the angles that face the edge sum to
// 120 degrees as in a regular mesh, to 1/4 at 180, where both diagonals would have been Delaunay's: weights
// there do not depend on the diagonal, and do not jump where a viewpoint that moves changes it.
//
// The limit is the third level with the weights that infinitely many levels would give its vertices, in
// closed form: interior 1 - n w own and w each neighbour, w = 1/5 for n = 3, else 1/(2 n). Between them it is
// linear, which is off by less than 1/60 (measured near the rim, loop_subdivision's test).
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "render/fields/triangle_topology.h"

namespace ulf::render {

// (vertex of the original mesh, weight), by ascending vertex.
using SparseWeights = std::vector<std::pair<int, double>>;

struct SubdividedMesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3d>
      outward;  // carried along: means at new vertices on boundary edges, zero inside
  std::vector<SparseWeights> weights;
  std::vector<Triangle> triangles;
  std::vector<int> parent;  // the original triangle that each lies in
};

inline constexpr int kFinestLevel = 3;
inline constexpr int kLimitLevel = 4;

enum class Diagonals {
  kDelaunay,  // of four corners on a circle either could have been taken
  kGiven,     // each edge is meant
};

// Level 0: each vertex is its own weight (piecewise linear); kLimitLevel: the limit.
SubdividedMesh SubdivideWeights(const std::vector<Eigen::Vector3d>& positions,
                                const std::vector<Eigen::Vector3d>& outward,
                                const std::vector<Triangle>& triangles, int levels,
                                Diagonals diagonals = Diagonals::kDelaunay);

}  // namespace ulf::render
