// Sets in the layout of the TUM RGB-D benchmark (Sturm et al. 2012): rgb.txt, a line `time file` for each photograph
// (seconds; the file counts from the folder), and beside it groundtruth.txt, a trajectory in TUM's format
// (core/geometry/trajectory.h; camera to world, metres). The two have times of their own, by one clock. The layout has
// no intrinsics. Depth images (depth.txt) are not used.
#pragma once

#include <filesystem>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

// `rgb_txt`: the list; the trajectory lies beside it. `images`: the folder from which the names count; empty: the list's.
// `camera`: of all photographs.
//
// A photograph's pose is interpolated between the poses before and after it, where these are at most 0.1 s apart; else
// it is the nearest one within 0.02 s (as the benchmark's associate.py takes it). Photographs without either, and those
// that are not there, are left out with a word in `doubts`. Views are in order of time, whatever the files' order. Throws
// Error that names file and line for a line that is none, a photograph that is named twice, and a name that leaves the
// folder; and Error with both ranges of time where no photograph has a pose.
PosedSet ReadTumSet(const std::filesystem::path& rgb_txt, const std::filesystem::path& images,
                    const CameraModel& camera);

}  // namespace ulf
