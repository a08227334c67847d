// What is wrong with a command line, and the way out, in place of the parser's own words where these name neither.
#pragma once

#include <string>

#include "commands/command_line.h"

namespace ulf::commands {

// Of the command line that `app` has just failed to parse. Empty: the parser's own words do.
std::string WrongUsageInWords(const CLI::App& app, const CLI::ParseError& error);

}  // namespace ulf::commands
