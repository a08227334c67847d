// Which points of a cloud a camera sees (CGAL's convex hull; GPL). A cloud hides nothing by itself: points
// are flipped over a large sphere about the camera, and hidden is what the flipped points' convex hull has
// inside (Katz, Tal, Basri: Direct Visibility of Point Sets, 2007). The sphere's radius follows from how
// densely points stand in the image: hidden is what lies a seventh of its distance or more behind its
// neighbours. Sole includer of CGAL's hull.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ulf::render {

// Indices of the points, in the camera's frame, that a camera with so many square radians of view sees from
// the origin; none of them lies there.
std::vector<std::size_t> VisiblePoints(const std::vector<Eigen::Vector3d>& in_cam, double view_sr);

}  // namespace ulf::render
