// Delaunay tetrahedra of points in space. They are CGAL's (GPL), which tetrahedra.cpp alone includes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace ulf::render {

// Inner cells are tetrahedra; the determinant of corners 1, 2 and 3 minus corner 0 is positive. An outer cell
// lies outside a face of the hull, and one of its corners is kAtInfinity.
struct Tetrahedra {
  static constexpr std::uint32_t kAtInfinity = 0xffffffff;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<std::uint32_t, 4>> corners;     // per cell: indices of points
  std::vector<std::array<std::uint32_t, 4>> neighbours;  // per cell: the cells opposite its corners

  bool Outer(std::uint32_t cell) const;
};

// Points at the same place become one. If `number` is not null, number[i] gets the index of points[i] among
// the result's points. Fewer than four points, or points in one plane, give no cells.
Tetrahedra DelaunayTetrahedra(const std::vector<Eigen::Vector3d>& points, std::vector<std::uint32_t>* number);

}  // namespace ulf::render
