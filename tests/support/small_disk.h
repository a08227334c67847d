// A disk of a few megabytes that a test can fill: a tmpfs in a mount namespace of this process's own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace ulf::test {

// Mounts one on `folder`, which must exist; as an ordinary user by way of a user namespace, for which no
// other thread may run yet. Gone with the process. Returns why it cannot, where that is not allowed.
std::optional<std::string> MountSmallDisk(const std::filesystem::path& folder, std::uint64_t bytes);

// Writes a file until the disk is full to the last block.
void FillDisk(const std::filesystem::path& file);

}  // namespace ulf::test
