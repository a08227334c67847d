// The axis of a turntable, and where a camera stood that looked at it, from the camera's poses about what
// turns.
//
// A camera that stands while the world turns about an axis sees that axis in one place: direction and point
// are the same in the frames of all its cameras. Two poses of one stand differ by a turn about the axis in
// the world, without a shift along it; the axis is that on which most pairs of neighbouring poses agree.
// World units.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/rigid3.h"

namespace ulf {

struct TurnAxis {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();  // the axis's nearest to the world's origin
  Eigen::Vector3d direction_in_world = Eigen::Vector3d::UnitZ();
};

// `cam_from_world` in order of time. None where too few pairs of poses differ by a turn about one axis: the
// subject did not turn, or the camera went along with something else.
std::optional<TurnAxis> FitTurnAxis(std::span<const Rigid3> cam_from_world);

// How far apart two cameras see the axis: 0 where the camera has not moved between them, whatever has turned.
struct StandShift {
  double direction = 0;    // radians
  double place_share = 0;  // of the axis's distance
};
StandShift ShiftBetween(const TurnAxis& axis, const Rigid3& a_from_world, const Rigid3& b_from_world);
bool IsSameStand(const StandShift& shift);

// Which stand each pose belongs to, counted from 0 in order of time. A pose while the camera is being moved
// is a stand of its own.
std::vector<int> StandsOf(const TurnAxis& axis, std::span<const Rigid3> cam_from_world);

}  // namespace ulf
