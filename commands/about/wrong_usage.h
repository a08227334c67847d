// What is wrong with a command line, and the way out, in place of the parser's own words where these name neither.
#pragma once

#include <string>

#include "commands/options/command_line.h"

namespace ulf::commands {

// Of the command line that `app` has just failed to parse. Empty: the parser's own words do.
std::string WrongUsageInWords(const CLI::App& app, const CLI::ParseError& error);

// Throws UsageError where a file that the parsed command writes is one that it reads, or a part of the light field that it
// reads: work would replace what it came from.
void RequireInputsStay(const CLI::App& app);

}  // namespace ulf::commands
