// Finds the axis of a turntable, and the stands (the times in which the camera stayed in one place), from the
// camera's poses relative to the turning subject, whose frame is the world.
//
// While the camera stays, the axis has the same place and direction in the camera frame of every pose. Two
// poses of one stand differ by a rotation about the axis in the world, without a shift along it; the axis is
// the one on which most pairs of neighbouring poses agree. Lengths are in world units.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/rigid3.h"

namespace ulf {

struct TurnAxis {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();  // the axis' point nearest to the world's origin
  Eigen::Vector3d direction_in_world = Eigen::Vector3d::UnitZ();  // unit; its sign is arbitrary
};

// Fits the axis to poses in order of time. Returns none if too few pairs of poses differ by a rotation
// about one axis: the subject did not turn, or the camera moved with something else.
std::optional<TurnAxis> FitTurnAxis(std::span<const Rigid3> cam_from_world);

// How far the axis differs between the camera frames of two poses: 0 if the camera has not moved.
struct StandShift {
  double direction = 0;    // radians
  double place_share = 0;  // displacement as a share of the axis' distance
};
StandShift ShiftBetween(const TurnAxis& axis, const Rigid3& a_from_world, const Rigid3& b_from_world);
// Returns whether the shift is as small as errors of the poses in one stand: 1 degree and 1.2 %.
bool IsSameStand(const StandShift& shift);

// Returns the number of each pose's stand, counted from 0 in order of time. A pose while the camera is being
// moved is a stand of its own.
std::vector<int> StandsOf(const TurnAxis& axis, std::span<const Rigid3> cam_from_world);

}  // namespace ulf
