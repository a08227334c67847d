// How much memory is left, and how much the C library keeps. Callers ask before they allocate much, because
// the system kills a process that takes more than there is.
#pragma once

#include <cstdint>

namespace ulf {

// Bytes that this process may still take: the least of what the machine, its control group and its own limit
// (ulimit -v) leave.
std::uint64_t AvailableMemory();

// For processes that run for hours with many threads: they share two heaps, where the C library would have up
// to eight a processor, each of which keeps what its threads freed. To be called before threads start;
// MALLOC_ARENA_MAX in the environment wins.
void ShareHeaps();

}  // namespace ulf
