#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddAcquisitionCommands(CLI::App& app, ChosenCommand& chosen);  // devices, simulate, import, export
}
