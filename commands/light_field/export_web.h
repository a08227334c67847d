// `ulf export web`.
#pragma once

#include <CLI/CLI.hpp>

#include "commands/options/subcommands.h"

namespace ulf::commands {

// Adds the form `web` to `ulf export`.
void AddExportWeb(CLI::App& command, ChosenCommand& chosen);

}  // namespace ulf::commands
