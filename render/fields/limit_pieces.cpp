#include "render/fields/limit_pieces.h"

#include <cmath>
#include <map>

#include "core/base/at.h"
#include "core/base/parallel_for.h"

namespace ulf::render {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kPiecesOfRings = 3 * LimitPieces::kRings + 1;

// One of the four parts of a triangle, in the order of PlaceOnCorner; columns are corners.
Matrix3d PartOf(const Matrix3d& corners, int corner) {
  const auto midpoint = [&](int a, int b) -> Vector3d {
    return (corners.col(a % 3) + corners.col(b % 3)) / 2;
  };
  Matrix3d part;
  if (corner == 3)
    part << midpoint(0, 1), midpoint(1, 2), midpoint(2, 0);
  else
    part << corners.col(corner), midpoint(corner, corner + 1), midpoint(corner, corner + 2);
  return part;
}

std::vector<Matrix3d> PiecesOf(const std::array<bool, 3>& has_rings) {
  const Matrix3d whole = Matrix3d::Identity();
  std::vector<Matrix3d> pieces{PartOf(whole, 3)};
  for (int corner = 0; corner < 3; ++corner) {
    Matrix3d left = PartOf(whole, corner);
    for (int ring = 0; has_rings[At(corner)] && ring < LimitPieces::kRings; ++ring) {
      for (int part = 1; part <= 3; ++part) pieces.push_back(PartOf(left, part));
      left = PartOf(left, 0);
    }
    pieces.push_back(left);
  }
  return pieces;
}

// Fills in `of`, whose pieces are counted from the triangle's own first one.
std::vector<LimitPieces::Piece> PiecesOfTriangle(const LimitSurface& surface, int t,
                                                 LimitPieces::OfTriangle& of) {
  constexpr double kLeastWeight = 1e-9;  // less is rounding
  for (int corner = 0; corner < 3; ++corner) of.has_rings[At(corner)] = !surface.IsRegular(t, corner);
  const std::vector<Matrix3d> corners = PiecesOf(of.has_rings);
  std::map<int, std::vector<std::array<double, kQuarticTerms>>> values_of;  // by vertex
  for (std::size_t piece = 0; piece < corners.size(); ++piece)
    for (std::size_t place = 0; place < kQuarticTerms; ++place) {
      const auto& [i, j, k] = QuarticExponents()[place];
      for (const auto& [vertex, weight] : surface.Weights(t, corners[piece] * Vector3d(i, j, k) / 4)) {
        if (std::abs(weight) < kLeastWeight) continue;
        auto& values = values_of[vertex];
        values.resize(corners.size());
        values[piece][place] = weight;
      }
    }
  std::vector<LimitPieces::Piece> pieces;
  for (const auto& [vertex, values] : values_of) {
    of.vertices.push_back(vertex);
    of.first_piece.push_back(static_cast<std::uint32_t>(pieces.size()));
    for (const auto& of_piece : values) {
      const auto coefficients = QuarticThrough(of_piece);
      LimitPieces::Piece& piece = pieces.emplace_back();
      for (std::size_t i = 0; i < coefficients.size(); ++i) piece[i] = static_cast<float>(coefficients[i]);
    }
  }
  return pieces;
}

}  // namespace

LimitPieces MakeLimitPieces(const LimitSurface& surface) {
  LimitPieces made;
  made.triangles.resize(At(surface.triangle_count()));
  std::vector<std::vector<LimitPieces::Piece>> pieces(made.triangles.size());
  ParallelFor(made.triangles.size(), [&](std::size_t t) {
    pieces[t] = PiecesOfTriangle(surface, static_cast<int>(t), made.triangles[t]);
  });
  for (std::size_t t = 0; t < pieces.size(); ++t) {
    for (std::uint32_t& first : made.triangles[t].first_piece)
      first += static_cast<std::uint32_t>(made.pieces.size());
    made.pieces.insert(made.pieces.end(), pieces[t].begin(), pieces[t].end());
  }
  return made;
}

PlaceInPiece FindPiece(const std::array<bool, 3>& has_rings, const Vector3d& barycentric) {
  PlaceOnCorner place = FirstLevelPlace(barycentric);
  if (place.corner == 3) return {0, place.barycentric};
  int piece = 1;
  for (int corner = 0; corner < place.corner; ++corner) piece += has_rings[At(corner)] ? kPiecesOfRings : 1;
  if (!has_rings[At(place.corner)]) return {piece, place.barycentric};
  for (int ring = 0; ring < LimitPieces::kRings; ++ring) {
    place = FirstLevelPlace(place.barycentric);
    if (place.corner != 0) return {piece + 3 * ring + place.corner - 1, place.barycentric};
  }
  return {piece + 3 * LimitPieces::kRings, place.barycentric};
}

}  // namespace ulf::render
