// Photographs for which there is no light field, or none that can be written: they are kept beside it, in a
// folder of its name with ".photographs" behind. Nothing that lies there is ever replaced.
#pragma once

#include <filesystem>

#include "core/image/frame.h"

namespace ulf::coverage {

std::filesystem::path FolderBeside(const std::filesystem::path& light_field);

// Under the next free number: the camera's own files, or the pixels where it gave none. Throws DiskFullError,
// Error.
void KeepBeside(const std::filesystem::path& folder, const Frame& frame);

}  // namespace ulf::coverage
