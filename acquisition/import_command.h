#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddImportCommand(CLI::App& app, ChosenCommand& chosen);
}
