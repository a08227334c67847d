// The commands and options of the program as values, read from CLI11, from which the manual and the
// completions are made, so that they cannot differ from --help.
#pragma once

#include <string>
#include <vector>

#include "commands/options/command_line.h"

namespace ulf::commands {

struct OptionPage {
  std::vector<std::string> names;  // "-o", "--output"; of a positional one, "DIR"
  std::string value;               // as in --help: "TEXT:{high,fast}"; empty: none
  std::string default_value;       // empty: none, or in its text
  std::string text;
  std::vector<std::string> words;  // the named values
  bool positional = false, required = false, repeats = false;
  bool takes_file = false;  // the value may be a path, too: free text, or not all values have names
};

struct CommandPage {
  std::vector<std::string> path;  // "export", "colmap"; empty for the program itself
  std::string text, footer;
  std::vector<OptionPage> options;
  std::vector<CommandPage> commands;

  std::string Name() const { return path.empty() ? std::string() : path.back(); }
  std::string FullName(const std::string& between) const;  // "ulf export colmap" with `between` as separator
};

// Returns all that --help shows, without hidden parts.
CommandPage CommandTree(const CLI::App& app);

// Returns the tree's pages, each before those below it.
std::vector<const CommandPage*> AllPages(const CommandPage& tree);

}  // namespace ulf::commands
