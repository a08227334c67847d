#pragma once

#include "commands/command_line.h"

namespace ulf {
void AddSheetCommand(CLI::App& app, ChosenCommand& chosen);
}
