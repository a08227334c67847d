// `ulf view`.
#pragma once

#include "acquisition/command_line.h"

namespace ulf {

void AddViewCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf
