// Checks, before the work begins, that its result can be written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace ulf {

// Throws UsageError when `path` is a folder, or its folder is missing or not writable.
void RequireWritable(const std::string& path);

// The same; throws also when the ending is not .png, .jpg or .jpeg.
void RequireWritablePicture(const std::string& path);

// Throws UsageError when the folder could not be made or written into; makes none.
void RequireFolderCanBeMade(const std::string& path);

// Throws DiskFullError when the disk of an existing folder has less room.
void RequireRoom(const std::filesystem::path& folder, std::uint64_t bytes);

// Makes the folder where it does not exist. Throws UsageError when it cannot be made or written into.
void RequireWritableFolder(const std::string& path);

}  // namespace ulf
