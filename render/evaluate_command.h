// `ulf evaluate`.
#pragma once

#include "acquisition/command_line.h"

namespace ulf {

void AddEvaluateCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf
