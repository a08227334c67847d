// `ulf refine`: the poses of a light field made better, and what that does to its coverage.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {

void AddRefineCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
