#include <spdlog/details/os.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <opencv2/core/utils/logger.hpp>
#include <string>

#include "commands/about/about_commands.h"
#include "commands/options/subcommands.h"
#include "commands/standard_streams.h"
#include "core/base/error.h"

namespace {

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// Before the constructors of the libraries, which may open files.
[[gnu::used,
  gnu::section(".preinit_array")]] void (*const fill_descriptors)() = ulf::commands::FillStandardDescriptors;
#endif

int Run(int argc, char** argv) {
  const bool has_colors = isatty(STDERR_FILENO) && spdlog::details::os::is_color_terminal();
  spdlog::set_default_logger(
      spdlog::stderr_color_mt("ulf", has_colors ? spdlog::color_mode::always : spdlog::color_mode::never));
  spdlog::set_pattern("%^%l%$: %v");

  // Our own errors report what fails.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_ERROR);
  CLI::App app{
      "ulf: captures, measures and renders unstructured light fields with one camera held in the hand.",
      "ulf"};
  app.require_subcommand(1);
  bool verbose = false;
  app.add_flag("-v,--verbose", verbose, "Say more");
  app.set_version_flag(
      "--version", [&verbose] { return ulf::commands::VersionText(verbose); },
      "Print the version and those of the libraries; with --verbose the renderer of OpenGL, too");
  app.set_help_all_flag("--help-all", "Help of every command");

  ulf::commands::ChosenCommand chosen;
  ulf::commands::AddCommands(app, chosen);
  ulf::commands::AddAboutCommands(app, chosen);

  if (argc == 1) {
    std::fputs(app.help().c_str(), stderr);
    return ulf::commands::kWrongUsage;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const std::string words = ulf::commands::WrongUsageInWords(app, error);
    if (words.empty()) return app.exit(error) == 0 ? ulf::commands::kOk : ulf::commands::kWrongUsage;
    std::fprintf(stderr, "ulf: %s\n", words.c_str());
    return ulf::commands::kWrongUsage;
  }
  if (verbose) spdlog::set_level(spdlog::level::debug);

  try {
    ulf::commands::RequireInputsStay(app);
    return chosen();
  } catch (const ulf::Refusal& refusal) {
    std::fprintf(stderr, "ulf: %s\n", refusal.what());
    return ulf::commands::kWrongUsage;
  } catch (const std::filesystem::filesystem_error& error) {
    std::fprintf(stderr, "ulf: %s: %s; check the path and its permissions\n", error.path1().c_str(),
                 error.code().message().c_str());
    return ulf::commands::kFailed;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ulf: %s\n", error.what());
    return ulf::commands::kFailed;
  }
}

// The exit status of a command whose report has been written, or could not be.
int ExitStatus(int of_command) {
  const int problem = ulf::commands::FlushStandardOutput();
  if (problem == 0) return of_command;
  std::fprintf(stderr, "ulf: standard output: the report could not be written: %s; %ssend it elsewhere\n",
               std::strerror(problem),
               of_command == ulf::commands::kOk ? "all else that was asked is done; " : "");
  return of_command == ulf::commands::kOk ? ulf::commands::kFailed : of_command;
}

}  // namespace

int main(int argc, char** argv) {
  ulf::SpellParameters(ulf::commands::OptionOf);
  ulf::commands::GuardStandardStreams();
  std::signal(SIGXFSZ, SIG_IGN);  // A file beyond what `ulimit -f` allows is an error.
  return ExitStatus(Run(argc, argv));
}
