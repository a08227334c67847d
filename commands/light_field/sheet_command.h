#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddSheetCommand(CLI::App& app, ChosenCommand& chosen);
}
