// ulf manual and ulf completion, which --help does not list: what an installation writes beside the program.
#pragma once

#include "commands/options/command_line.h"

namespace ulf::commands {

// They tell of all commands and options of `app`, also those that are added later.
void AddAboutCommands(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
