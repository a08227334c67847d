// Triangulates a point from rays. Poses are cam_from_world, rays are unit vectors in the camera frame.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "core/geometry/rigid3.h"

namespace ulf {

// Returns the point of two rays in world coordinates, by the inverse-depth-weighted midpoint (Lee and Civera
// 2019), which is accurate at small parallax; none if it would lie behind a camera or the rays are parallel.
std::optional<Eigen::Vector3d> TriangulatePoint(const Rigid3& first_from_world,
                                                const Eigen::Vector3d& ray_in_first,
                                                const Rigid3& second_from_world,
                                                const Eigen::Vector3d& ray_in_second);

struct RayObservation {
  Rigid3 cam_from_world;
  Eigen::Vector3d ray_in_cam;
};

// Returns the point in world coordinates with the least sum of squared distances from the rays, each divided
// by its depth; none for fewer than two rays, if they are parallel, or if the point lies behind a camera.
std::optional<Eigen::Vector3d> TriangulatePoint(std::span<const RayObservation> observations);

// Returns the angle at a point between the directions to two camera centres in the world, in radians.
double ParallaxAngle(const Eigen::Vector3d& point_in_world, const Eigen::Vector3d& first_center,
                     const Eigen::Vector3d& second_center);

}  // namespace ulf
