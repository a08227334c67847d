#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddSimulateCommand(CLI::App& app, ChosenCommand& chosen);
}
