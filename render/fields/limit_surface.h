// The weights to which subdivision converges, exactly, at any place of any triangle.
//
// After the first level (whose rule differs under kDelaunay, loop_subdivision.h) all rules are Loop's, and
// each small triangle has at most one vertex of the original mesh. Where its three vertices are regular, the
// limit is the quartic box spline of twelve vertices (box_spline.h). On a rim those that lack are put there:
// with phantom = a + b - c beyond an edge (a, b) of the triangle (a, b, c), the rules of the inside give what
// the rule of the rim gives. A vertex is regular inside with six neighbours, on the rim with four; under
// kDelaunay an original vertex of the rim never is, because it keeps its weight.
//
// At another vertex (Stam, "Evaluation of Loop subdivision surfaces", 1998) each level leaves three regular
// triangles of four. The vertex with the two rings around it is a star; `S` makes the star of the next level
// out of a star, so the place is doubled k times until it lies in one of the three, and the box spline is
// over S^k times the star. Stam takes the power from the eigenvectors of S; here S, which has few entries, is
// applied k times. After kMostRings, where the place is the vertex itself to rounding, the limit is known in
// closed form.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <memory>
#include <vector>

#include "render/fields/box_spline.h"
#include "render/fields/loop_subdivision.h"

namespace ulf::render {

// The place of a triangle after its first level, and in it the place of a point.
struct PlaceOnCorner {
  int corner = 3;  // the small triangle at this corner; 3: the one in the middle
  // In the order (corner, next, next but one); in the middle of the midpoints of the edges 01, 12, 20.
  Eigen::Vector3d barycentric;
};
PlaceOnCorner FirstLevelPlace(const Eigen::Vector3d& barycentric);

class LimitSurface {
 public:
  // As SubdivideWeights().
  LimitSurface(const std::vector<Eigen::Vector3d>& positions, const std::vector<Triangle>& triangles,
               SubdivisionRules rules = SubdivisionRules::kDelaunay);

  // In ascending order of vertices of the original mesh; barycentric coordinates sum to one.
  SparseWeights Weights(int triangle, const Eigen::Vector3d& barycentric) const;
  // Whether the limit is one polynomial over the small triangle at a corner of a triangle.
  bool IsRegular(int triangle, int corner) const;
  int triangle_count() const { return static_cast<int>(patches_.size()); }

 private:
  using Controls = std::array<SparseWeights, kBoxSplineVertices>;
  struct Star {
    std::vector<SparseWeights> next;               // of each vertex of the next level's star: S
    std::vector<std::array<Controls, 3>> patches;  // of each sector the three regular triangles
    SparseWeights limit;                           // at the vertex in the middle
  };
  struct Corner {
    const Star* star = nullptr;  // null: regular
    int sector = 0;
  };
  struct Patches {  // of a triangle
    Controls middle;
    std::array<Controls, 3> regular;  // at regular corners
    std::array<Corner, 3> corners;
  };

  static Star MakeStar(int sectors, bool on_rim, SubdivisionRules rules);
  static Controls ControlsOf(const Triangle& of, const std::map<std::pair<int, int>, int>& opposite);
  SparseWeights AtStar(const Corner& corner, int hub, const Eigen::Vector3d& barycentric) const;

  std::vector<Triangle> triangles_;
  std::vector<SparseWeights> weights_;  // of the vertices after the first level
  std::vector<Patches> patches_;
  std::vector<std::vector<int>>
      star_vertices_;  // of each original vertex: which of `weights_` its star is of
  std::map<std::pair<int, bool>, std::unique_ptr<const Star>> stars_;  // by sectors and whether on the rim
};

}  // namespace ulf::render
