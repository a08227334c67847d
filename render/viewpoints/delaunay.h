// Delaunay triangulations of directions and of points in the plane (CGAL; GPL). Only its source includes
// CGAL's triangulations on the sphere and in the plane.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "render/viewpoints/triangle_topology.h"

namespace ulf::render {

// Triangulates directions on the unit sphere, without seam or pole. CGAL closes a sphere on which the
// directions leave a hemisphere or more empty with ghost faces; they are left out, so that an open cap
// remains. `directions` are unit vectors, no two closer than 1e-6. Triangles are counter-clockwise as seen
// from outside. The result is empty if the directions span no surface: fewer than four, or all in one plane
// (on one circle: a ring).
std::vector<Triangle> SphericalDelaunay(const std::vector<Eigen::Vector3d>& directions);

// A triangle of unit vectors whose corners span a smaller volume with the origin lies on one great circle: it
// has no outside, and rounding may flip it.
inline constexpr double kLeastDirectionVolume = 1e-14;

// Triangulates points in the plane. Triangles are counter-clockwise (x right, y up) and cover the convex hull
// of the points.
std::vector<Triangle> PlanarDelaunay(const std::vector<Eigen::Vector2d>& points);

}  // namespace ulf::render
