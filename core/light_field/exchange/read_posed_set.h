// Finds out in which format a set of posed photographs is, and reads it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/formats/posed_set.h"
#include "core/light_field/formats/set_format.h"

namespace ulf {

// `format`: none: the first of FormatsIn(), with a doubt that names the others. `images`: the folder of the
// photographs where the format names them without it; empty: found by itself. `camera`: of the photographs,
// for a format that has no intrinsics, and for none else: Refusal. Throws Error for a source that holds no
// such set, with the way in which videos and plain photographs can be used, and what the readers throw.
PosedSet ReadPosedSet(const std::filesystem::path& source, const std::optional<SetFormat>& format,
                      const std::filesystem::path& images, const std::optional<CameraModel>& camera = {});

}  // namespace ulf
