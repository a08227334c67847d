#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddInfoCommand(CLI::App& app, ChosenCommand& chosen);
}
