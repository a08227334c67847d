// COLMAP's binary model: cameras.bin, images.bin, points3D.bin. Readers prefer it to a text model in the same
// folder.
#pragma once

#include "core/light_field/exchange/colmap_text.h"

namespace ulf {

ColmapFiles ToColmapBinary(const ColmapReconstruction& model);

}  // namespace ulf
