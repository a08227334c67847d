// Reads the program's commands and options from CLI11 into values. The manual and the shell completions are
// made from them, so that they agree with --help.
#pragma once

#include <string>
#include <vector>

#include "commands/options/command_line.h"

namespace ulf::commands {

struct OptionPage {
  std::vector<std::string> names;  // "-o", "--output"; "DIR" for a positional argument
  std::string value;               // as in --help: "TEXT:{high,fast}"; empty for a flag
  std::string default_value;       // empty: there is none, or `text` tells it
  std::string text;                // description
  std::vector<std::string> words;  // named values: "high", "fast"
  bool positional = false, required = false, repeats = false;
  bool takes_file = false;  // The value may be a path: it is free text, or its named values end in FILE.
};

struct CommandPage {
  std::vector<std::string> path;  // "export", "colmap"; empty for the program itself
  std::string text, footer;
  std::vector<OptionPage> options;
  std::vector<CommandPage> commands;

  std::string Name() const { return path.empty() ? std::string() : path.back(); }
  std::string FullName(const std::string& between) const;  // "ulf export colmap" with `between` as separator
};

// Returns the page of the whole program, without what --help hides.
CommandPage CommandTree(const CLI::App& app);

// Returns all pages of the tree, each before its subcommands'; they point into `tree`.
std::vector<const CommandPage*> AllPages(const CommandPage& tree);

}  // namespace ulf::commands
