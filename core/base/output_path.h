// Checks, before the work begins, that its result can be written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace ulf {

// Throws Refusal when `path` is a folder, or its folder is missing or not writable.
void RequireWritable(const std::string& path);

// Throws Refusal where a file of this name holds anything but `bytes`: what a user has is not replaced
// unasked. A pipe or a device takes whatever comes.
void RequireUnused(const std::string& path, std::string_view bytes = {});

// As RequireWritable(); throws also when the ending is not .png, .jpg or .jpeg.
void RequireWritablePicture(const std::string& path);

// Throws Refusal when the folder could not be made or written into; makes none.
void RequireFolderCanBeMade(const std::string& path);

// Throws DiskFullError when the disk of an existing folder has less room.
void RequireRoom(const std::filesystem::path& folder, std::uint64_t bytes);

// Makes the folder where it does not exist. Throws Refusal when it cannot be made or written into.
void RequireWritableFolder(const std::string& path);

}  // namespace ulf
