// Delaunay triangulation of directions on the unit sphere (CGAL; GPL). It has neither seam nor pole. Where
// the directions leave a hemisphere or more empty, CGAL closes the sphere there with ghost faces, which are
// left out here: what remains is an open cap. Sole includer of CGAL's sphere.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "render/fields/triangle_topology.h"

namespace ulf::render {

// `directions` are unit vectors, no two closer than 1e-6. Triangles are counter-clockwise as seen from
// outside. Empty when the directions span no surface: fewer than four, or all in one plane (any circle: a
// ring).
std::vector<Triangle> SphericalDelaunay(const std::vector<Eigen::Vector3d>& directions);

}  // namespace ulf::render
