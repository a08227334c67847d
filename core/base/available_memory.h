// How much memory is left. Callers ask before they allocate much, because the system kills a process that
// takes more than there is.
#pragma once

#include <cstdint>

namespace ulf {

// Bytes that this process may still take: the least of what the machine, its control group and its own limit
// (ulimit -v) leave.
std::uint64_t AvailableMemory();

}  // namespace ulf
