#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddProxyCommand(CLI::App& app, ChosenCommand& chosen);
}
