// Tells how much memory is left, and limits what the C library keeps. Callers ask before they allocate much,
// because the system kills a process that takes more than there is.
#pragma once

#include <cstdint>

namespace ulf {

// Returns the bytes that this process may still take: the least of what the machine, its container (cgroup 2)
// and its own limit (ulimit -v) leave.
std::uint64_t AvailableMemory();

// Limits the C library to two heaps, for processes that run for hours with many threads: by default it has
// up to eight heaps a processor, each of which keeps what its threads freed. Call it before threads start;
// MALLOC_ARENA_MAX in the environment has precedence.
void ShareHeaps();

}  // namespace ulf
