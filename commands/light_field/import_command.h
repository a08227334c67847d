#pragma once

#include "commands/command_line.h"

namespace ulf {
void AddImportCommand(CLI::App& app, ChosenCommand& chosen);
}
