// Saves photographs for which the light field does not exist yet or cannot be written: in the folder
// "NAME.photographs" beside the light field NAME. Existing files there are never replaced.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/frames/frame.h"
#include "core/light_field/folder/light_field_writer.h"

namespace ulf::coverage {

// Keeps a frame in unposed/ of the folder `light_field`, through its `writer` (null: there is none), or else
// beside that folder. Returns where; none: neither could be written, and `problem` says why.
std::optional<std::filesystem::path> SavePhotograph(LightFieldWriter* writer,
                                                    const std::filesystem::path& light_field,
                                                    const Frame& frame, std::string& problem);

}  // namespace ulf::coverage
