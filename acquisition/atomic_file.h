// Files that are either whole or absent, whatever kills the process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace ulf {

// Writes to a temporary name beside `path`, syncs it, renames it, syncs the folder. Throws DiskFullError or
// Error (no permission) and leaves nothing behind then.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);

void SyncFolder(const std::filesystem::path& folder);

// With all folders above it. Throws Error naming what stands in the way.
void MakeFolder(const std::filesystem::path& folder);

// What this user may still write there; the largest number where the system does not say.
std::uint64_t FreeBytes(const std::filesystem::path& folder);

// Throws what fits an errno: DiskFullError when there is no room, else Error.
[[noreturn]] void ThrowDiskError(int reason, const std::string& what_failed);

std::string ReadWholeFile(const std::filesystem::path& path);

// The ending of WriteFileAtomically's temporary names: leftovers of a kill, safe to remove.
inline constexpr std::string_view kTemporaryEnding = ".part";

}  // namespace ulf
