// `ulf view`.
#pragma once

#include "commands/command_line.h"

namespace ulf {

void AddViewCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf
