#include "render/commands.h"

#include <CLI/CLI.hpp>

namespace ulf {

void AddRenderCommands(CLI::App& /*app*/, ChosenCommand& /*chosen*/) {}

}  // namespace ulf
