// Declares the functions that add the subcommands. Each subcommand has a file of its name in a folder of
// commands/ that parses, calls one function, and prints. Its function adds it to the program's command line,
// so that parsing sets `chosen` to the function to run if the user chose it.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <utility>

#include "commands/options/command_line.h"

namespace ulf::commands {

// Adds all subcommands, in the order of the help.
void AddCommands(CLI::App& app, ChosenCommand& chosen);

using AddSubcommand = void(CLI::App& app, ChosenCommand& chosen);
AddSubcommand AddDevicesCommand, AddFeaturesCommand, AddSimulateCommand, AddRecordCommand, AddImportCommand,
    AddRepairCommand, AddBoardCommand, AddCalibrateCommand, AddCalibrationCommand, AddTrackCommand,
    AddRenderCommand, AddEvaluateCommand, AddMaskCommand, AddProxyCommand, AddViewCommand, AddPlanCommand,
    AddCaptureCommand, AddInfoCommand, AddSheetCommand, AddReviewCommand, AddTakeBackCommand,
    AddRefineCommand, AddExportCommand, AddMergeCommand;

// Adds a subcommand, described by `text`. Returns it and its arguments, for the caller's options. If the user
// chooses it, parsing sets `chosen`, which must outlive `app`, to a call of `run` with the arguments.
template <typename Args>
std::pair<CLI::App*, std::shared_ptr<Args>> NewSubcommand(CLI::App& app, ChosenCommand& chosen,
                                                          const std::string& name, const std::string& text,
                                                          int (*run)(const Args& args)) {
  const auto args = std::make_shared<Args>();
  CLI::App* command = app.add_subcommand(name, text);
  command->callback([args, run, &chosen] { chosen = [args, run] { return run(*args); }; });
  return {command, args};
}

}  // namespace ulf::commands
