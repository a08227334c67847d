#pragma once

#include "commands/command_line.h"

namespace ulf {
void AddProxyCommand(CLI::App& app, ChosenCommand& chosen);
}
