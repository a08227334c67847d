#pragma once

#include "commands/command_line.h"

namespace ulf {
void AddRepairCommand(CLI::App& app, ChosenCommand& chosen);
}
