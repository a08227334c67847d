// The way back for a camera whose position is not known while its turns are followed
// (tracking/tracker/turn_tracker.h).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/tracker/tracker.h"

namespace ulf::coverage {

// How a camera without a pose is turned.
struct CameraTurn {
  // To the camera's axes now (x right, y down, z forward), from those that it had then.
  Eigen::Quaterniond now_from_then = Eigen::Quaterniond::Identity();
  // Then: the last frame with a pose; false: the first frame, and there was no pose yet.
  bool from_a_pose = false;

  // Where the camera looked then, in its axes now; unit length.
  Eigen::Vector3d Then() const { return now_from_then * Eigen::Vector3d::UnitZ(); }
  // To turn by, radians, so that it looks there again.
  double Angle() const;
};

// "turn 40° left, 5° up": what to do to look where the camera looked then. Empty where it looks there, within
// kThere_deg.
std::string TurnBackInWords(const CameraTurn& turned);
inline constexpr double kThere_deg = 4;  // a small part of any picture. Guessed

// Before a map has started: the camera is turned and not moved, whatever else stands in the way.
bool OnlyTurns(tracking::TrackState state, const std::optional<tracking::StartProgress>& start,
               const std::optional<CameraTurn>& turned);

// Why there is no pose, and what to do: tracking/tracker/track.h with what is known of the turn, to
// which nobody can turn back in pictures that are taken already.
std::string InWords(const tracking::Track& track, const std::optional<CameraTurn>& turned,
                    FrameSource source);

// The border of the picture of then, where the present picture has it: lines between neighbours, in pixels.
// As if all were far away, since nobody knows how the camera moved. Empty where it is all behind.
std::vector<std::vector<Eigen::Vector2d>> PictureOfThen(const CameraTurn& turned, const CameraModel& camera);

}  // namespace ulf::coverage
