// Finds the axis of a turntable, and the places where the camera stood, from the camera's poses relative to
// the turning subject.
//
// A camera that stands while the world turns about an axis sees that axis in one place: direction and point
// are the same in the frames of all its cameras. Two poses of one stand differ by a rotation about the axis
// in the world, without a shift along it; the axis is that on which most pairs of neighbouring poses agree.
// Lengths are in world units.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/rigid3.h"

namespace ulf {

struct TurnAxis {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();  // the axis' point nearest to the world's origin
  Eigen::Vector3d direction_in_world = Eigen::Vector3d::UnitZ();
};

// Fits the axis to poses in order of time. Returns none if too few pairs of poses differ by a rotation
// about one axis: the subject did not turn, or the camera moved with something else.
std::optional<TurnAxis> FitTurnAxis(std::span<const Rigid3> cam_from_world);

// The difference between two cameras' views of the axis: 0 if the camera has not moved between them.
struct StandShift {
  double direction = 0;    // radians
  double place_share = 0;  // displacement as a share of the axis' distance
};
StandShift ShiftBetween(const TurnAxis& axis, const Rigid3& a_from_world, const Rigid3& b_from_world);
bool IsSameStand(const StandShift& shift);

// Returns the stand of each pose, counted from 0 in order of time. A pose while the camera is being moved
// is a stand of its own.
std::vector<int> StandsOf(const TurnAxis& axis, std::span<const Rigid3> cam_from_world);

}  // namespace ulf
