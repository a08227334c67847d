// Completion of the command line in a shell: commands, options, the values that an option knows by name, and files where
// a value may be one.
#pragma once

#include <string>

#include "commands/about/command_tree.h"

namespace ulf::commands {

// "bash", "zsh" or "fish"; throws UsageError for any other.
std::string CompletionScript(const CommandPage& tree, const std::string& shell);

}  // namespace ulf::commands
