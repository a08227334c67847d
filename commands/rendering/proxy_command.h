// `ulf proxy`.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {

void AddProxyCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
