#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddSheetCommand(CLI::App& app, ChosenCommand& chosen);
}
