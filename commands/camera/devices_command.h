#pragma once

#include "commands/command_line.h"

namespace ulf {
void AddDevicesCommand(CLI::App& app, ChosenCommand& chosen);
}
