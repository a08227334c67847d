#pragma once

#include "commands/command_line.h"

namespace ulf {
void AddSimulateCommand(CLI::App& app, ChosenCommand& chosen);
}
