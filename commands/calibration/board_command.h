// `ulf board`: a calibration target to be printed.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddBoardCommand(CLI::App& app, ChosenCommand& chosen);
}  // namespace ulf::commands
