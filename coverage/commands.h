#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddCoverageCommands(CLI::App& app, ChosenCommand& chosen);  // capture, plan, info
}
