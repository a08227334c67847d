// `ulf track`: poses of a sequence, its error against a truth, and what tracking costs.
#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddTrackCommand(CLI::App& app, ChosenCommand& chosen);
}
