#include "commands/about/about_commands.h"
#include "commands/options/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <numeric>
#include <string_view>
#include <vector>

namespace ulf::commands {
namespace {
namespace fs = std::filesystem;

// Returns the command that the words lead to: for `ulf export colmap ...` that of colmap.
const CLI::App& ChosenOf(const CLI::App& app) {
  const CLI::App* chosen = &app;
  while (!chosen->get_subcommands().empty()) chosen = chosen->get_subcommands().front();
  return *chosen;
}

std::string FullNameOf(const CLI::App& app) {
  return app.get_parent() == nullptr ? app.get_name() : FullNameOf(*app.get_parent()) + " " + app.get_name();
}

// Counts letters that are added, left out or replaced (Levenshtein).
std::size_t LettersBetween(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

// Suggests a similar name in a clause for people; empty if none is similar.
std::string Nearest(const std::string& given, const std::vector<std::string>& names) {
  constexpr std::size_t kMostLetters = 2;  // a swapped pair counts as two. Guessed
  std::string nearest;
  std::size_t least = kMostLetters + 1;
  for (const std::string& name : names) {
    const std::size_t letters = name.starts_with(given) ? 1 : LettersBetween(given, name);
    if (letters >= least) continue;
    least = letters;
    nearest = name;
  }
  return nearest.empty() ? "" : fmt::format("; do you mean '{}'?", nearest);
}

std::vector<std::string> CommandsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_name().empty() && !command->get_group().empty()) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> OptionsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames())
      if (!option->get_group().empty()) names.push_back("--" + name);
  return names;
}

// These options name files to write. `ulf calibration` may write what it reads, and checks that first.
bool IsOutput(const CLI::App& command, const CLI::Option& option) {
  constexpr std::array<std::string_view, 8> kOutputs{"--output",          "--final",      "--table",
                                                     "--calibration-out", "--screenshot", "--map",
                                                     "--overlay",         "--preview"};
  return command.get_name() != "calibration" &&
         std::ranges::find(kOutputs, "--" + option.get_single_name()) != kOutputs.end();
}

// Returns the path that may be read: a device's name may hold one (replay:DIR?fps=5).
fs::path PathIn(const std::string& value) {
  const std::size_t begin = value.starts_with("replay:") ? std::string_view("replay:").size() : 0;
  const std::string path = value.substr(begin, value.find('?', begin) - begin);
  return path.empty() ? fs::path(value) : fs::path(path);
}

// Returns whether an existing file belongs to the folder's record: it lies deeper, or is no picture, mesh or
// film at its top.
bool IsRecordOf(const fs::path& folder, const fs::path& file) {
  const fs::path inside = fs::weakly_canonical(file).lexically_relative(fs::weakly_canonical(folder));
  if (inside.empty() || *inside.begin() == "..") return false;
  const std::string ending = file.extension().string();
  return inside.has_parent_path() || ending == ".json" || ending == ".jsonl" || ending == ".txt";
}

}  // namespace

void RequireInputsStay(const CLI::App& app) {
  const CLI::App& command = ChosenOf(app);
  std::vector<std::string> written, read;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& value : option->results())
      (IsOutput(command, *option) ? written : read).push_back(value);
  std::error_code unknown;
  for (const std::string& out : written) {
    if (!fs::is_regular_file(out, unknown)) continue;
    for (const std::string& in : read) {
      const fs::path path = PathIn(in);
      if (fs::equivalent(out, path, unknown) || (fs::is_directory(path, unknown) && IsRecordOf(path, out)))
        throw UsageError("{}: is what '{}' reads and would be replaced; give another name", out,
                         FullNameOf(command));
    }
  }
}

std::string WrongUsageInWords(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return {};  // --help
  const std::string words = error.what();
  if (const auto colon = words.find(": At Most 1 required"); colon != std::string::npos)
    return words.substr(0, colon) + " is given more than once; give it once";
  const CLI::App& chosen = ChosenOf(app);
  const std::string name = FullNameOf(chosen);
  const std::vector<std::string> unknown = chosen.remaining();
  const auto option = std::ranges::find_if(unknown, [](const auto& word) { return word.starts_with("--"); });
  if (option != unknown.end()) {
    const std::string given = option->substr(0, option->find('='));
    return fmt::format("{} has no option '{}'{}; '{} --help' lists them", name, given,
                       Nearest(given, OptionsOf(chosen)), name);
  }
  if (const std::vector<std::string> commands = CommandsOf(chosen); !commands.empty()) {
    if (unknown.empty()) return fmt::format("{} needs one of: {}", name, fmt::join(commands, ", "));
    constexpr std::size_t kMostNamed = 12;
    return fmt::format("there is no command '{} {}'{}; {}", name, unknown.front(),
                       Nearest(unknown.front(), commands),
                       commands.size() > kMostNamed ? fmt::format("'{} --help' lists them", name)
                                                    : fmt::format("there are {}", fmt::join(commands, ", ")));
  }
  return {};
}

}  // namespace ulf::commands
