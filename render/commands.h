#pragma once

#include "acquisition/command_line.h"

namespace ulf {
void AddRenderCommands(CLI::App& app, ChosenCommand& chosen);  // render, evaluate, proxy
}
