#pragma once

#include "commands/command_line.h"

namespace ulf {
void AddCaptureCommand(CLI::App& app, ChosenCommand& chosen);
}
