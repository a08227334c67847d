#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddRepairCommand(CLI::App& app, ChosenCommand& chosen);
}
