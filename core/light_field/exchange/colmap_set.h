// A reconstruction by COLMAP as a set of posed photographs: binary (which COLMAP itself prefers) or text, with points,
// their tracks, and masks as COLMAP has them (masks/NAME.png beside the images folder).
#pragma once

#include <filesystem>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

// `images`: the folder of the photographs; empty: images, images_2, images_4, images_8, input or photos, beside or around the
// model, or where the model lies. Views are numbered in the order of their names. Photographs without a pose, and
// poses without a photograph, are left out with a word; other numbered models beside the one that is read are named. Throws Error for a model that cannot be read, and where no
// photograph is found.
PosedSet ReadColmapSet(const std::filesystem::path& source, const std::filesystem::path& images);

}  // namespace ulf
