// ulf record: every frame of a device to disk, for a session to be run again.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddRecordCommand(CLI::App& app, ChosenCommand& chosen);
}  // namespace ulf::commands
