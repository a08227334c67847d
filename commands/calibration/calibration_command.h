// `ulf calibration`: what a calibration file says, and the same for other programs.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddCalibrationCommand(CLI::App& app, ChosenCommand& chosen);
}  // namespace ulf::commands
