// Finds the points of a cloud that a camera sees, although points have no surface that hides others. They are
// flipped over a large sphere about the camera; a point is hidden if its flipped point lies inside the convex
// hull of all flipped points (Katz, Tal, Basri: Direct Visibility of Point Sets, 2007). The sphere's radius
// follows from the density of the points in the image. The hull is CGAL's (GPL).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ulf::render {

// A point is hidden if it lies farther behind its neighbours than this share of its distance. Guessed.
inline constexpr double kHiddenBehind = 0.15;

// `in_cam` are points in the camera's frame, none of them at the origin. `view_sr` is the camera's field of
// view in steradians. Returns the indices of the points that are visible from the origin, ascending.
std::vector<std::size_t> VisiblePoints(const std::vector<Eigen::Vector3d>& in_cam, double view_sr);

}  // namespace ulf::render
