// A disk and a network of this process's own, by namespaces of the kernel.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace ulf::test {

// A disk of a few megabytes that a test can fill: a tmpfs in a mount namespace of this process's own.
//
// Mounts one on `folder`, which must exist; as an ordinary user by way of a user namespace, for which no
// other thread may run yet. Gone with the process. Returns why it cannot, where that is not allowed.
std::optional<std::string> MountSmallDisk(const std::filesystem::path& folder, std::uint64_t bytes);

// Writes a file until the disk is full to the last block.
void FillDisk(const std::filesystem::path& file);

// A network of this process's own: the loopback interface and nothing else. Every GigE Vision camera listens
// on the one UDP port 3956, so two tests at once, or a test beside a real camera, would talk to each other's.
//
// Moves this process (and what it starts) into a network namespace with loopback up; as an ordinary user by
// way of a user namespace. To be called before any thread is started. Returns why it cannot, where it is not
// allowed.
std::optional<std::string> EnterLoopbackNamespace();

}  // namespace ulf::test
