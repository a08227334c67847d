// Reads the poses of a set by any program, for camera paths.
#pragma once

#include <filesystem>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf {

struct SetPoses {
  std::vector<Rigid3> cam_from_world;  // in the set's world and the order of its views
  std::vector<CameraModel>
      cameras;  // one for each pose; empty where the set does not tell the pictures' size
};

// Reads a light field, a .json file with frames, or a set in one of the formats of set_format.h. The
// photographs need not be there, but of formats that do not say how large they are, and of layouts of folders
// (Polycam, TUM, EuRoC, KITTI), which ReadPosedSet() reads. Warns of what is not used. Throws Error for
// what is none of these.
SetPoses ReadPosesOfSet(const std::filesystem::path& source);

}  // namespace ulf
