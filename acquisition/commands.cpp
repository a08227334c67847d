#include "acquisition/commands.h"

#include <CLI/CLI.hpp>

namespace ulf {

void AddAcquisitionCommands(CLI::App& /*app*/, ChosenCommand& /*chosen*/) {}

}  // namespace ulf
