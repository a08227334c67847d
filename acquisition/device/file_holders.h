// Finds the programs that have a file open: when a device node cannot be opened, another program often uses
// it.
#pragma once

#include <string>
#include <vector>

namespace ulf::acquisition {

// The other programs that have `path` open, such as "cheese (process 4711)", as far as this user may see
// them. `proc`: the folder in which the kernel lists processes.
std::vector<std::string> ProgramsHolding(const std::string& path, const std::string& proc = "/proc");

}  // namespace ulf::acquisition
