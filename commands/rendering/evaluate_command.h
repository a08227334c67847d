// `ulf evaluate`.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {

void AddEvaluateCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
