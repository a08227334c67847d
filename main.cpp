#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <opencv2/core/utils/logger.hpp>
#include <string>

#include "commands/about/about_commands.h"
#include "commands/about/version_text.h"
#include "commands/about/wrong_usage.h"
#include "commands/commands.h"
#include "core/base/error.h"

int main(int argc, char** argv) {
  std::signal(SIGPIPE,
              SIG_IGN);  // writing to a camera that is gone must return an error, not end the process
  spdlog::set_default_logger(spdlog::stderr_color_mt("ulf"));
  spdlog::set_pattern("%^%l%$: %v");

  // Our own errors report what fails.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_ERROR);
  CLI::App app{
      "ulf: captures, measures and renders unstructured light fields with one camera held in the hand.",
      "ulf"};
  app.require_subcommand(1);
  app.set_version_flag("--version", ulf::commands::VersionText,
                       "Print the version, those of the libraries, and the renderer of OpenGL");
  app.set_help_all_flag("--help-all", "Help of every command");
  bool verbose = false;
  app.add_flag("-v,--verbose", verbose, "Say more");

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
    return chosen();
  } catch (const ulf::UsageError& error) {
    std::fprintf(stderr, "ulf: %s\n", error.what());
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
