#pragma once

#include "commands/command_line.h"

namespace ulf {
void AddPlanCommand(CLI::App& app, ChosenCommand& chosen);
}
