// Finds which way is up in the world of photographs that people took.
//
// People hold a camera level: its right axis is at right angles to up, or its up axis where they turned it by
// 90 degrees for a portrait. Up is the direction at right angles to these axes by weighted least squares (the
// smallest eigenvector of their scatter), with the axis that fits better for each camera, and less weight for
// cameras that are tilted. It is not the mean of the cameras' up axes, which leans towards the subject where
// all look down from one side, and sideways where some photographs are turned.
//
// If all cameras face nearly the same way, their axes leave the pitch open. Then they look straight ahead on
// average, as far as the axes' spread does not tell more than their noise. If n cameras face directions that
// spread by s and are held with a tilt of t (standard deviations), the pitch is known to t / (s sqrt(n)): on
// an arc of 20 degrees held to 1.5 degrees to 4 degrees by twelve cameras, to 2 by sixty. Nothing else in the
// poses tells more: such an arc's own plane is lost in the heights of a hand.
#pragma once

#include <Eigen/Core>
#include <span>

namespace ulf {

// Returns a unit vector in the world, from rotations cam_from_world (x right, y down, z forward). Upwards is
// what more of the cameras call so, and away from where they look. Returns -y without cameras.
Eigen::Vector3d UpOfCameras(std::span<const Eigen::Matrix3d> cam_from_world);

}  // namespace ulf
