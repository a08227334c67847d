#pragma once

#include "commands/command_line.h"

namespace ulf::commands {
void AddCaptureCommand(CLI::App& app, ChosenCommand& chosen);
}
