#pragma once

#include "commands/command_line.h"

namespace ulf {
void AddInfoCommand(CLI::App& app, ChosenCommand& chosen);
}
