#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddDevicesCommand(CLI::App& app, ChosenCommand& chosen);
}
