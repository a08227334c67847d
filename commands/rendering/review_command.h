// ulf review: a look round a light field with a marker in the hand.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {

void AddReviewCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
