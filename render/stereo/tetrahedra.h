// Delaunay tetrahedra of points in space (CGAL; GPL). Only its source includes CGAL's 3D triangulations.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace ulf::render {

// The determinant of corners 1, 2 and 3 minus corner 0 is positive. Neighbour k lies opposite corner k. An
// outer cell lies outside a face of the hull; one of its corners is kAtInfinity.
struct Tetrahedra {
  static constexpr std::uint32_t kAtInfinity = 0xffffffff;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<std::uint32_t, 4>> corners;
  std::vector<std::array<std::uint32_t, 4>> neighbours;

  bool Outer(std::uint32_t cell) const;
};

// Points at the same place become one vertex: `number[i]` is the vertex of points[i]. Fewer than four points,
// or points in one plane, give no cells.
Tetrahedra DelaunayTetrahedra(const std::vector<Eigen::Vector3d>& points, std::vector<std::uint32_t>* number);

}  // namespace ulf::render
