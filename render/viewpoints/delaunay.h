// Delaunay triangulations of directions and of points in the plane. CGAL (GPL) makes them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "render/viewpoints/triangle_topology.h"

namespace ulf::render {

// Triangulates directions on the unit sphere, without seam or pole. Where they leave a hemisphere or more
// empty, no triangle closes the sphere, and an open cap remains. `directions` are unit vectors, no two closer
// than 1e-6. Triangles are counter-clockwise as seen from outside. The result is empty for fewer than four
// directions, and if all lie on one circle (a ring of views).
std::vector<Triangle> SphericalDelaunay(const std::vector<Eigen::Vector3d>& directions);

// A triangle of unit vectors with at most this determinant counts as lying on one great circle: it has no
// outside, and rounding may flip it. SphericalDelaunay() leaves it out.
inline constexpr double kLeastDirectionVolume = 1e-14;

// Triangulates points in the plane. Triangles are counter-clockwise (x right, y up) and cover the convex hull
// of the points; there are none if all points lie on a line.
std::vector<Triangle> PlanarDelaunay(const std::vector<Eigen::Vector2d>& points);

}  // namespace ulf::render
