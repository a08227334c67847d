// How much memory there still is: asked before much is taken, because a process that takes more than there is
// gets killed without a word.
#pragma once

#include <cstdint>

namespace ulf {

// What this process may still take: of the machine, of its control group, and of its own limit (ulimit -v).
std::uint64_t AvailableMemory();

}  // namespace ulf
