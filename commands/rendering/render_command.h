// `ulf render`.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {

void AddRenderCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
