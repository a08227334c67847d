// COLMAP's binary model: cameras.bin, images.bin, points3D.bin. Readers prefer it to a text model in the same
// folder.
#pragma once

#include "core/light_field/formats/colmap_text.h"

namespace ulf {

ColmapFiles ToColmapBinary(const ColmapReconstruction& model);

// DIR/cameras.bin, images.bin and, where it is there, points3D.bin. Throws Error that names the file, for one that is
// cut short, whose counts lie, or whose values make no camera or pose.
ColmapReconstruction ReadColmapBinary(const std::filesystem::path& dir);

}  // namespace ulf
