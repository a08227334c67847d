// Adds the forms of `ulf export` that need the renderer: glTF, quilts for light-field displays, pages for
// browsers.
#pragma once

#include "commands/options/command_line.h"

namespace ulf::commands {

// Each adds its forms to `ulf export`.
void AddSceneForms(CLI::App& command, ChosenCommand& chosen);
void AddExportWeb(CLI::App& command, ChosenCommand& chosen);  // export_web.cpp

}  // namespace ulf::commands
