#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddTrackingCommands(CLI::App& app, ChosenCommand& chosen);  // track
}
