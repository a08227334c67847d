// COLMAP's binary model: cameras.bin, images.bin, points3D.bin. Where it stands beside the text, readers take
// this one.
#pragma once

#include "core/light_field/exchange/colmap_text.h"

namespace ulf {

ColmapFiles ToColmapBinary(const ColmapReconstruction& model);

}  // namespace ulf
