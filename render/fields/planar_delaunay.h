// Delaunay triangulation of points in the plane (CGAL; GPL). Sole includer of CGAL's plane.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "render/fields/triangle_topology.h"

namespace ulf::render {

// Triangles are counter-clockwise (x right, y up) and cover the points' convex hull.
std::vector<Triangle> PlanarDelaunay(const std::vector<Eigen::Vector2d>& points);

}  // namespace ulf::render
