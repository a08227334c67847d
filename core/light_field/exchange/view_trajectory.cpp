#include "core/light_field/exchange/view_trajectory.h"

#include <limits>

namespace ulf {
namespace {

double TimeOf(const View& view, TrajectoryTimes times) {
  switch (times) {
    case TrajectoryTimes::kDevice:
      return view.device_time_s;
    case TrajectoryTimes::kHost:
      return view.host_time_s;
    case TrajectoryTimes::kNumbers:
      break;
  }
  return view.id;
}

// A time of 0 is one that nobody noted, but for a device's clock, which may begin there.
bool TimesGrow(const LightField& light_field, TrajectoryTimes times) {
  double last_s = -std::numeric_limits<double>::infinity();
  for (const View& view : light_field.views) {
    const double time_s = TimeOf(view, times);
    if (!(time_s > last_s) || (times == TrajectoryTimes::kHost && !(time_s > 0))) return false;
    last_s = time_s;
  }
  return light_field.views.size() > 1 || last_s > 0;
}

}  // namespace

std::string InWords(TrajectoryTimes times) {
  switch (times) {
    case TrajectoryTimes::kDevice:
      return "seconds by the camera's clock";
    case TrajectoryTimes::kHost:
      return "seconds since 1970 at which photographs arrived";
    case TrajectoryTimes::kNumbers:
      break;
  }
  return "numbers of views";
}

ViewTrajectory TrajectoryOf(const LightField& light_field) {
  ViewTrajectory trajectory;
  for (const TrajectoryTimes times : {TrajectoryTimes::kHost, TrajectoryTimes::kDevice})
    if (TimesGrow(light_field, times)) trajectory.times = times;
  for (const View& view : light_field.views)
    trajectory.poses.push_back({TimeOf(view, trajectory.times), view.cam_from_world});
  return trajectory;
}

}  // namespace ulf
