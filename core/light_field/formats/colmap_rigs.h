// Reads and writes COLMAP's rigs and frames, which lie beside the other files of a model from version 3.12 on
// (rigs.bin and frames.bin, or .txt; src/colmap/scene/reconstruction_io_binary.cc and _text.cc). A rig holds
// sensors whose poses are fixed to each other, a frame is one exposure of a rig:
//   sensor_from_world = sensor_from_rig * rig_from_world,  the first sensor of a rig having sensor_from_rig 1
// Where there are frames COLMAP takes poses from them alone; those in its file of images are copies.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "core/geometry/rigid3.h"
#include "core/light_field/formats/colmap_model.h"

namespace ulf {

// Returns the poses cam_from_world by the number of the image, of all images whose frame, rig and sensor have
// a pose; none if one of the two files is missing. Throws an Error that names a file that is cut short, has
// wrong counts or no numbers.
std::map<std::uint32_t, Rigid3> ReadColmapRigPoses(const std::filesystem::path& dir, bool binary);

// Gives each image of a model that was read in `dir` its pose by its rig, if it has one, and normalises the
// quaternions of the others; `doubts` says so where it makes a difference. Throws as ReadColmapRigPoses() and
// NormalizeColmapPose() do.
void SettleColmapPoses(const std::filesystem::path& dir, bool binary, ColmapReconstruction& model);

// The contents of the two files.
struct ColmapRigFiles {
  std::string rigs, frames;
};
// Makes a rig of each camera and a frame of each image, with its number, as COLMAP does by itself.
ColmapRigFiles ToColmapRigs(const ColmapReconstruction& model, bool binary);

}  // namespace ulf
