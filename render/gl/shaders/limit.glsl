// The limit of subdivision over a triangle: in which of its pieces a place lies, and where there (FindPiece(), with
// LIMIT_RINGS rings at corners that have some); the coefficients of the pieces of all views.
layout(std430, binding = 4) readonly buffer LimitPieces { mat4 limit_pieces[]; };

// The part of a triangle, 0 to 2 at its corners and 3 in the middle, and the place in it.
int PartAt(inout vec3 place) {
  vec3 p = place;
  int corner = p.x >= 0.5 ? 0 : p.y >= 0.5 ? 1 : p.z >= 0.5 ? 2 : 3;
  if (corner == 3) {
    place = 1.0 - 2.0 * p.zxy;
  } else {
    vec2 others = 2.0 * (corner == 0 ? p.yz : corner == 1 ? p.zx : p.xy);
    place = vec3(1.0 - others.x - others.y, others);
  }
  return corner;
}

// `rings`: bits of the corners that have rings.
int PieceAt(inout vec3 place, int rings) {
  const int kPiecesOfRings = 3 * LIMIT_RINGS + 1;
  int corner = PartAt(place);
  if (corner == 3) return 0;
  int piece = 1;
  if (corner > 0) piece += (rings & 1) != 0 ? kPiecesOfRings : 1;
  if (corner > 1) piece += (rings & 2) != 0 ? kPiecesOfRings : 1;
  if ((rings >> corner & 1) == 0) return piece;
  for (int ring = 0; ring < LIMIT_RINGS; ++ring) {
    int part = PartAt(place);
    if (part != 0) return piece + 3 * ring + part - 1;
  }
  return piece + 3 * LIMIT_RINGS;
}

// Bernstein's polynomials in the order of QuarticExponents(), and a zero.
mat4 QuarticTerms(vec3 p) {
  vec3 p2 = p * p, p3 = p2 * p, p4 = p2 * p2;
  return mat4(p4.x, 4.0 * p3.x * p.y, 4.0 * p3.x * p.z, 6.0 * p2.x * p2.y,
              12.0 * p2.x * p.y * p.z, 6.0 * p2.x * p2.z, 4.0 * p.x * p3.y, 12.0 * p.x * p2.y * p.z,
              12.0 * p.x * p.y * p2.z, 4.0 * p.x * p3.z, p4.y, 4.0 * p3.y * p.z,
              6.0 * p2.y * p2.z, 4.0 * p.y * p3.z, p4.z, 0.0);
}

float LimitWeight(uint first_piece, int piece, mat4 terms) {
  mat4 of = limit_pieces[first_piece + uint(piece)];
  return dot(terms[0], of[0]) + dot(terms[1], of[1]) + dot(terms[2], of[2]) + dot(terms[3], of[3]);
}
