// The views of a light field as a trajectory, for programs that read TUM files (core/geometry/trajectory.h).
#pragma once

#include <string>
#include <vector>

#include "core/geometry/trajectory.h"
#include "core/light_field/light_field.h"

namespace ulf {

// What the times of a trajectory are. Programs that read trajectories want times that grow from pose to pose:
// the first of these counts that does so over all views, in order of id.
enum class TrajectoryTimes {
  kDevice,  // View::device_time_s
  kHost,    // View::host_time_s: the device's clock began anew, as it does in another session
  kNumbers  // View::id: the light field knows no times, or they do not grow
};
// Returns what they are in words, which follow "times are ".
std::string InWords(TrajectoryTimes times);

struct ViewTrajectory {
  TrajectoryTimes times = TrajectoryTimes::kNumbers;
  std::vector<TimedPose> poses;  // of all views, in order of id, in the light field's world
};
ViewTrajectory TrajectoryOf(const LightField& light_field);

}  // namespace ulf
