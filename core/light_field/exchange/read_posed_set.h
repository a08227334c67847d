// Recognises the format of a set of posed photographs and reads it.
#pragma once

#include <filesystem>
#include <optional>

#include "core/light_field/formats/posed_set.h"
#include "core/light_field/formats/set_format.h"

namespace ulf {

// `source` is a file or the folder of a set, or a folder with one below, at most three levels down. `format`
// is by default the first of FormatsIn(), with a doubt that names the others. `images` is the folder
// of the photographs, searched for if empty. `camera` must be given for formats without intrinsics (TUM), and
// for no other; otherwise Refusal is thrown. Throws Error for a source without such a set, with the way to
// use videos and plain photographs, for a photograph with two different poses, and what the readers throw.
PosedSet ReadPosedSet(const std::filesystem::path& source, const std::optional<SetFormat>& format,
                      const std::filesystem::path& images, const std::optional<CameraModel>& camera = {});

}  // namespace ulf
