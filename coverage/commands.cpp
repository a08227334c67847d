#include "coverage/commands.h"

#include <CLI/CLI.hpp>

namespace ulf {

void AddCoverageCommands(CLI::App& /*app*/, ChosenCommand& /*chosen*/) {}

}  // namespace ulf
