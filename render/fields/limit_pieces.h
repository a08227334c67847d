// The limit of subdivision as polynomials for a shader: a triangle is cut into pieces, and over each piece the
// weight of a vertex is a quartic with fifteen coefficients (QuarticBernstein).
//
// The pieces of a triangle are the one in the middle; then at corners 0, 1 and 2 one where the corner is
// regular, else kRings times three, ring by ring towards the corner, and one for what is left there. All are
// exact but the last, where the limit is no polynomial and the quartic through fifteen of its values serves.
// That is off by less than 1/255 of full weight (limit_surface_test: valences 3 to 40; at most 1/1800 inside
// and up to 1/290 on a rim of many neighbours).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "render/fields/limit_surface.h"

namespace ulf::render {

struct LimitPieces {
  static constexpr int kRings = 3;  // the shader's loop has the same
  struct OfTriangle {
    std::array<bool, 3> has_rings{};         // of the corners
    std::vector<int> vertices;               // that weigh in the triangle, ascending
    std::vector<std::uint32_t> first_piece;  // of each, in `pieces`
  };
  using Piece = std::array<float, 16>;  // fifteen coefficients and a zero
  std::vector<OfTriangle> triangles;
  std::vector<Piece> pieces;
};

LimitPieces MakeLimitPieces(const LimitSurface& surface);

struct PlaceInPiece {
  int piece = 0;  // of the triangle
  Eigen::Vector3d barycentric;
};
// What the shader does.
PlaceInPiece FindPiece(const std::array<bool, 3>& has_rings, const Eigen::Vector3d& barycentric);

}  // namespace ulf::render
