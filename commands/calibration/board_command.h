// `ulf board`: draws a calibration target for printing.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddBoardCommand(CLI::App& app, ChosenCommand& chosen);
}  // namespace ulf::commands
