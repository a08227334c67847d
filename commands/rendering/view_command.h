// `ulf view`.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {

void AddViewCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
