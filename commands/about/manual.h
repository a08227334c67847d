// Man pages: ulf(1), and one for each command, in the macros of man(7).
#pragma once

#include <filesystem>
#include <string>

#include "commands/about/command_tree.h"

namespace ulf::commands {

// The page of one command; `tree` is the whole program's, for what it refers to.
std::string ManPage(const CommandPage& page, const CommandPage& tree, const std::string& version);

// ulf.1, ulf-capture.1, ulf-export-colmap.1 and so on into a folder that is there. Throws Error that names the file
// that cannot be written.
void WriteManual(const CommandPage& tree, const std::string& version, const std::filesystem::path& folder);

}  // namespace ulf::commands
