#pragma once
#include "commands/command_line.h"

namespace ulf::commands {

void AddFeaturesCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
