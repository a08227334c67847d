// Describes the way back for a camera whose rotation is tracked while its position is not known
// (tracking/tracker/turn_tracker.h).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/tracker/track.h"

namespace ulf::coverage {

// Describes how a camera without a pose is turned.
struct CameraTurn {
  // Rotates from the camera's axes at the reference frame to its present ones (x right, y down, z forward).
  Eigen::Quaterniond now_from_reference = Eigen::Quaterniond::Identity();
  // The reference frame is the last frame with a pose; false: the first frame, and there was no pose yet.
  bool reference_has_pose = false;

  // Returns the optical axis at the reference frame in the present camera's axes; unit length.
  Eigen::Vector3d ReferenceAxis() const { return now_from_reference * Eigen::Vector3d::UnitZ(); }
  // Returns the angle, radians, to turn back by.
  double Angle() const;
};

// Returns "turn 40° left, 5° up", the way back to the reference direction; empty within kReachedDeg of it.
std::string TurnBackInWords(const CameraTurn& turned);
inline constexpr double kReachedDeg = 4;  // a small part of any picture. Guessed

// Returns whether no map could start because the camera is rotated and not moved sideways; too few matches
// with the first picture count as that, too.
bool IsPureRotation(tracking::TrackState state, const std::optional<tracking::StartProgress>& start,
                    const std::optional<CameraTurn>& turned);

// Returns why there is no pose, and what to do: the text of tracking/tracker/track.h and, for a live camera,
// the way back.
std::string InWords(const tracking::Track& track, const std::optional<CameraTurn>& turned,
                    FrameSource source);

// Returns the reference frame's border in the present picture: polylines in pixels, empty where all of it is
// behind. The scene counts as infinitely far away, since the camera's translation is not known.
std::vector<std::vector<Eigen::Vector2d>> FormerFrameOutline(const CameraTurn& turned,
                                                             const CameraModel& camera);

}  // namespace ulf::coverage
