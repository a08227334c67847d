// Delaunay triangulation of points in the plane (CGAL; GPL). The only file that includes CGAL's plane.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "render/viewpoints/triangle_topology.h"

namespace ulf::render {

// Triangles are counter-clockwise (x right, y up) and cover the convex hull of the points.
std::vector<Triangle> PlanarDelaunay(const std::vector<Eigen::Vector2d>& points);

}  // namespace ulf::render
