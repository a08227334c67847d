// `ulf export colmap|nerfstudio`: a light field as other programs want it, its points measured anew.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {

void AddExportCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
