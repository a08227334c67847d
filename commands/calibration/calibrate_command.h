// `ulf calibrate`: estimates intrinsics from a board, or the flat field from a card.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddCalibrateCommand(CLI::App& app, ChosenCommand& chosen);
}  // namespace ulf::commands
