// `ulf calibration`: prints a calibration file and converts it to other formats.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddCalibrationCommand(CLI::App& app, ChosenCommand& chosen);
}  // namespace ulf::commands
