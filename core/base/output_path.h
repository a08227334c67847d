// Checks, before the work begins, that its result can be written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace ulf {

// Throws Refusal when `path` is a folder, or its folder is missing or not writable.
void RequireWritable(const std::string& path);

// Throws Refusal if a file of this name holds anything but `bytes`, so that a user's file is not replaced
// unasked. A pipe or a device is accepted.
void RequireUnused(const std::string& path, std::string_view bytes = {});

// Checks as RequireWritable() does, and that the ending is .png, .jpg or .jpeg.
void RequireWritablePicture(const std::string& path);

// Throws Refusal when the folder could not be made or written into; makes none.
void RequireFolderCanBeMade(const std::string& path);

// Throws DiskFullError if the disk of an existing folder has less room.
void RequireRoom(const std::filesystem::path& folder, std::uint64_t bytes);

// Makes the folder if it does not exist. Throws Refusal if it cannot be made or written into.
void RequireWritableFolder(const std::string& path);

}  // namespace ulf
