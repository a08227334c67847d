// Sets in the format of NeRF's synthetic scenes (Mildenhall et al. 2020): transforms_train.json, transforms_val.json and
// transforms_test.json with one field of view and pictures with alpha in train/, val/ and test/.
#pragma once

#include <filesystem>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

// All views of all parts that are there, in this order, twice what two parts name; the names of the photographs begin
// with the part's. `images` and errors as of ReadTransformsSet().
PosedSet ReadNerfSyntheticSet(const std::filesystem::path& folder, const std::filesystem::path& images = {});

}  // namespace ulf
