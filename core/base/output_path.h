// Checks, before the work begins, that its result can be written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace ulf {

// Throws Refusal when `path` is a folder, or its folder is missing or not writable.
void RequireWritable(const std::string& path);

// Throws Refusal if a regular file is there and holds anything but `bytes`: it is not replaced unasked.
void RequireUnused(const std::string& path, std::string_view bytes = {});

// Checks as RequireWritable() does, and that the ending is .png, .jpg or .jpeg.
void RequireWritablePicture(const std::string& path);

// Throws Refusal if the folder could not be made or written into. Does not make it.
void RequireFolderCanBeMade(const std::string& path);

// Throws DiskFullError if the disk of this existing folder has less room than `bytes`.
void RequireRoom(const std::filesystem::path& folder, std::uint64_t bytes);

// Makes the folder if it does not exist. Throws Refusal if it cannot be made or written into.
void RequireWritableFolder(const std::string& path);

}  // namespace ulf
