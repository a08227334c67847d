// `ulf export colmap|nerfstudio`: exports a light field for other programs, with points measured again.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {

void AddExportCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
