// Gives photographs with times their poses of a trajectory.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/trajectory.h"
#include "core/light_field/formats/posed_set.h"

namespace ulf {

struct TimedPhotograph {
  double time_s = 0;
  std::string name;
  int line = 0;  // in the list
};

// Adds views in order of time. `list` names the photographs and `trajectory` has the poses, in messages;
// their times are by one clock. Names are relative to the folder of `images`, `camera` is that of all
// photographs.
//
// A photograph's pose is interpolated between the poses before and after it if these are at most 0.1 s apart;
// otherwise it is the nearest one within 0.02 s (as in associate.py of the TUM RGB-D benchmark). Photographs
// without either, and missing ones, are left out and named in `doubts`. Throws an Error that names file and
// line for a photograph that is named twice and a name that leaves the folder; and Error if no photograph has
// a pose, or fewer are there than are missing.
void AddTimedViews(std::vector<TimedPhotograph> photographs, std::vector<TimedPose> poses,
                   const std::filesystem::path& list, const std::filesystem::path& trajectory,
                   const SetImages& images, const CameraModel& camera, PosedSet& set);

}  // namespace ulf
