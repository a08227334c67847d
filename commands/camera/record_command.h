// `ulf record`: records every frame of a device, so that a session can be run again.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddRecordCommand(CLI::App& app, ChosenCommand& chosen);
}  // namespace ulf::commands
