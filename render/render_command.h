// `ulf render`.
#pragma once

#include "acquisition/command_line.h"

namespace ulf {

void AddRenderCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf
