// All subcommands, in the order in which the help lists them.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddCommands(CLI::App& app, ChosenCommand& chosen);
}
