// Delaunay tetrahedra of points in space.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace ulf::render {

// Corners run so that the determinant of (corner 1, 2, 3) - corner 0 is positive. Neighbour k lies across
// from corner k. An outer cell has the face on the hull's and no fourth corner: kAtInfinity.
struct Tetrahedra {
  static constexpr std::uint32_t kAtInfinity = 0xffffffff;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<std::uint32_t, 4>> corners;
  std::vector<std::array<std::uint32_t, 4>> neighbours;
  std::vector<std::uint32_t> cell_at;  // some cell of each point that is not an outer one if there is one

  bool Outer(std::uint32_t cell) const;
};

// Points at the same place are one: `number[i]` is the vertex of points[i]. Fewer than four points, or points
// in one plane, give no cells.
Tetrahedra DelaunayTetrahedra(const std::vector<Eigen::Vector3d>& points, std::vector<std::uint32_t>* number);

}  // namespace ulf::render
