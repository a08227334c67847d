// Describes the program and its command line: version, man pages, completion, and faults of a command line.
#pragma once

#include <filesystem>
#include <string>

#include "commands/about/command_tree.h"
#include "commands/options/command_line.h"

namespace ulf::commands {

// Adds `ulf manual`, which --help does not list, and `ulf completion`. They make the files that an
// installation puts beside the program, and describe all commands and options that `app` has when they run.
void AddAboutCommands(CLI::App& app, ChosenCommand& chosen);

// Returns the output of `ulf --version` for bug reports: "ulf 0.1.0" in the first line, then the libraries
// that it was built with. If `asks_opengl` is set, a third line names the OpenGL renderer that works without
// a window, or says why there is none; this loads the driver (some 0.3 s).
std::string VersionText(bool asks_opengl);

// Returns the man page of one command in the macros of man(7) (manual.cpp). `tree` describes the whole
// program (CommandTree()), to which the page refers.
std::string ManPage(const CommandPage& page, const CommandPage& tree, const std::string& version);
// Writes ulf.1, ulf-capture.1, ulf-export-colmap.1 and so on into an existing folder. Throws Error that names
// the file that cannot be written.
void WriteManual(const CommandPage& tree, const std::string& version, const std::filesystem::path& folder);

// Returns the completion of the command line in a shell: commands, options, named values, and files if a
// value may be one (completion.cpp). `shell` is "bash", "zsh" or "fish"; throws UsageError for any other.
std::string CompletionScript(const CommandPage& tree, const std::string& shell);

// Describes the fault of the command line that `app` has just failed to parse, and the remedy
// (wrong_usage.cpp). Returns "" if the parser's own message does, or if `error` stands for --help.
std::string WrongUsageInWords(const CLI::App& app, const CLI::ParseError& error);

// Throws UsageError if the parsed command would replace a file that it reads, or a file in a folder that it
// reads, other than pictures, meshes and films at the folder's top. Exempt is `ulf calibration`.
void RequireInputsStay(const CLI::App& app);

}  // namespace ulf::commands
