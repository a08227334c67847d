#pragma once
#include "acquisition/command_line.h"

namespace ulf {

void AddFeaturesCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf
