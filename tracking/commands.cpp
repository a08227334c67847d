#include "tracking/commands.h"

#include <CLI/CLI.hpp>

namespace ulf {

void AddTrackingCommands(CLI::App& /*app*/, ChosenCommand& /*chosen*/) {}

}  // namespace ulf
