// Files that are either whole or absent, whatever kills the process.
#pragma once

#include <filesystem>
#include <string_view>

namespace ulf {

// Writes to a temporary name beside `path`, syncs it, renames it, syncs the folder. Throws Error (disk full,
// no permission) and leaves nothing behind then.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);

void SyncFolder(const std::filesystem::path& folder);

std::string ReadWholeFile(const std::filesystem::path& path);

// The ending of WriteFileAtomically's temporary names: leftovers of a kill, safe to remove.
inline constexpr std::string_view kTemporaryEnding = ".part";

}  // namespace ulf
