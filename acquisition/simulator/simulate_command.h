#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddSimulateCommand(CLI::App& app, ChosenCommand& chosen);
}
