// `ulf review`: shows a light field from where the user holds a marker.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {

void AddReviewCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
