// Sets in the format of Local Light Field Fusion (Mildenhall et al. 2019): poses_bounds.npy and photographs that lie in
// images, or reduced by N in images_N. The row of a photograph, in the order of names as computers sort them, holds
// a 3x5 matrix, row by row, whose columns are down, right, back, centre and (height, width, focal length), then the
// nearest and the farthest depth. There is no lens distortion.
#pragma once

#include <filesystem>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

// `source`: the folder, or the file. `images`: the folder of the photographs; empty: images, or else the largest of
// images_2, images_4, images_8. Throws Error where the file is damaged, a row is no pose, or the number of
// photographs is another one than that of the rows.
PosedSet ReadLlffSet(const std::filesystem::path& source, const std::filesystem::path& images);

}  // namespace ulf
