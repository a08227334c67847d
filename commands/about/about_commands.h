// Describes the program and its command line: version, man pages, completion, and faults of a command line.
#pragma once

#include <filesystem>
#include <string>

#include "commands/about/command_tree.h"
#include "commands/options/command_line.h"

namespace ulf::commands {

// Adds ulf manual and ulf completion, which --help does not list: they make the files that an installation
// puts beside the program. They describe all commands and options of `app`, also those that are added later.
void AddAboutCommands(CLI::App& app, ChosenCommand& chosen);

// Returns the output of `ulf --version`, which a report of a fault needs: "ulf 0.1.0" in the first line, then
// the libraries that it was built with (a Debian release keeps their versions). With `asks_opengl` also the
// renderer that OpenGL has without a window, for which its driver is loaded (some 0.3 s); if there is none,
// the line says why.
std::string VersionText(bool asks_opengl);

// Returns the man page of one command, in the macros of man(7); `tree` is the whole program's, for
// cross-references (manual.cpp).
std::string ManPage(const CommandPage& page, const CommandPage& tree, const std::string& version);
// Writes ulf.1, ulf-capture.1, ulf-export-colmap.1 and so on into an existing folder. Throws Error that names
// the file that cannot be written.
void WriteManual(const CommandPage& tree, const std::string& version, const std::filesystem::path& folder);

// Returns the completion of the command line in a shell: commands, options, named values, and files if a
// value may be one (completion.cpp). `shell` is "bash", "zsh" or "fish"; throws UsageError for any other.
std::string CompletionScript(const CommandPage& tree, const std::string& shell);

// Describes the fault of the command line that `app` has just failed to parse, with the remedy, if the
// parser's own words name neither (wrong_usage.cpp). Returns "" if the parser's own words do.
std::string WrongUsageInWords(const CLI::App& app, const CLI::ParseError& error);

// Throws UsageError if a file that the parsed command writes is one that it reads, or a part of the light
// field that it reads: the output would replace its source.
void RequireInputsStay(const CLI::App& app);

}  // namespace ulf::commands
