#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddDevicesCommand(CLI::App& app, ChosenCommand& chosen);
}
