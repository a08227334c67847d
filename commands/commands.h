// Adds all subcommands, in the order of the help.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddCommands(CLI::App& app, ChosenCommand& chosen);
}
