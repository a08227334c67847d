// Adds the subcommands of `ulf export` that write no set of photographs.
#pragma once

#include "commands/options/command_line.h"

namespace ulf::commands {

// `command` is that of `ulf export`.
void AddSceneForms(CLI::App& command, ChosenCommand& chosen);  // glTF, and quilts for light-field displays
void AddFileForms(CLI::App& command, ChosenCommand& chosen);  // one file: poses, or points (export_files.cpp)
void AddExportSplat(CLI::App& command, ChosenCommand& chosen);  // Gaussians (export_splat.cpp)
void AddExportWeb(CLI::App& command, ChosenCommand& chosen);    // the page for browsers (export_web.cpp)

}  // namespace ulf::commands
