#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddInfoCommand(CLI::App& app, ChosenCommand& chosen);
}
