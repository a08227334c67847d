// What the program tells about itself and its command line: version, man pages, completion, and what is wrong
// with a command line.
#pragma once

#include <filesystem>
#include <string>

#include "commands/about/command_tree.h"
#include "commands/options/command_line.h"

namespace ulf::commands {

// ulf manual and ulf completion, which --help does not list: what an installation writes beside the program.
// They tell of all commands and options of `app`, also those that are added later.
void AddAboutCommands(CLI::App& app, ChosenCommand& chosen);

// What `ulf --version` says, which a report of a fault needs: "ulf 0.1.0" in the first line, then the
// libraries that it was built with (a Debian release keeps their versions). With `asks_opengl` also the
// renderer that OpenGL has without a window, for which its driver is loaded (some 0.3 s); where there is
// none, the line says why.
std::string VersionText(bool asks_opengl);

// Man page of one command, in the macros of man(7); `tree` is the whole program's, for what it refers to
// (manual.cpp).
std::string ManPage(const CommandPage& page, const CommandPage& tree, const std::string& version);
// ulf.1, ulf-capture.1, ulf-export-colmap.1 and so on into a folder that is there. Throws Error that names
// the file that cannot be written.
void WriteManual(const CommandPage& tree, const std::string& version, const std::filesystem::path& folder);

// Completion of the command line in a shell: commands, options, the values that an option knows by name, and
// files where a value may be one (completion.cpp). `shell`: "bash", "zsh" or "fish"; throws UsageError for
// any other.
std::string CompletionScript(const CommandPage& tree, const std::string& shell);

// What is wrong with the command line that `app` has just failed to parse, and the way out, in place of the
// parser's own words where these name neither (wrong_usage.cpp). Empty: the parser's own words do.
std::string WrongUsageInWords(const CLI::App& app, const CLI::ParseError& error);

// Throws UsageError where a file that the parsed command writes is one that it reads, or a part of the light
// field that it reads: work would replace what it came from.
void RequireInputsStay(const CLI::App& app);

}  // namespace ulf::commands
