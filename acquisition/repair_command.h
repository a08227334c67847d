#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddRepairCommand(CLI::App& app, ChosenCommand& chosen);
}
