#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddImportCommand(CLI::App& app, ChosenCommand& chosen);
}
