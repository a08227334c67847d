// The forms of `ulf export` that are made with the renderer: glTF, and quilts for light-field displays.
#pragma once

#include "commands/options/command_line.h"

namespace ulf::commands {

// Adds them to `ulf export`.
void AddSceneForms(CLI::App& command, ChosenCommand& chosen);

}  // namespace ulf::commands
