// Gives this process a disk and a network of its own, by namespaces of the kernel.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace ulf::test {

// Mounts a disk of `bytes` that a test can fill on `folder`, which must exist: a tmpfs in a mount namespace
// of this process's own, which ends with it. An ordinary user gets it by way of a user namespace, for which
// no other thread may run yet. Returns why it cannot be mounted; none: it is.
std::optional<std::string> MountSmallDisk(const std::filesystem::path& folder, std::uint64_t bytes);

// Writes a file until the disk is full to the last block.
void FillDisk(const std::filesystem::path& file);

// Moves this process (and what it starts) into a network of its own, the loopback interface and nothing else:
// every GigE Vision camera listens on the one UDP port 3956, so that two tests at once, or a test beside a
// real camera, would talk to each other's. An ordinary user gets it by way of a user namespace. Call it
// before any thread is started. Returns why it is not possible; none: it is done.
std::optional<std::string> EnterLoopbackNamespace();

}  // namespace ulf::test
