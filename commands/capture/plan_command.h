#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddPlanCommand(CLI::App& app, ChosenCommand& chosen);
}
