// The commands and options of the program as values, read from CLI11: what the manual and the completions are
// made of, so that they cannot differ from --help.
#pragma once

#include <string>
#include <vector>

#include "commands/options/command_line.h"

namespace ulf::commands {

struct OptionPage {
  std::vector<std::string> names;  // "-o", "--output"; of a positional one, "DIR"
  std::string value;               // as --help has it: "TEXT:{high,fast}"; empty: it takes none
  std::string default_value;       // empty: none, or its text tells it
  std::string text;
  std::vector<std::string> words;  // the values that it knows by name
  bool positional = false, required = false, repeats = false;
  bool takes_file = false;  // the value may be a path, too: it is free text, or the words are not all
};

struct CommandPage {
  std::vector<std::string> path;  // "export", "colmap"; of the program itself empty
  std::string text, footer;
  std::vector<OptionPage> options;
  std::vector<CommandPage> commands;

  std::string Name() const { return path.empty() ? std::string() : path.back(); }
  std::string FullName(const std::string& between) const;  // "ulf export colmap" with blanks between
};

// All that --help shows; what is hidden there is left out here.
CommandPage CommandTree(const CLI::App& app);

// The tree's pages, each before those below it.
std::vector<const CommandPage*> AllPages(const CommandPage& tree);

}  // namespace ulf::commands
