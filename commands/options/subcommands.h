// Declares the subcommands: each has a file of its name in a room of commands/ that parses, calls one
// function, and prints. A function adds its subcommand to the program's command line and, if the user chose
// it, sets `chosen` to the function to run.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <utility>

#include "commands/options/command_line.h"

namespace ulf::commands {

// Adds all, in the order of the help.
void AddCommands(CLI::App& app, ChosenCommand& chosen);

using AddSubcommand = void(CLI::App& app, ChosenCommand& chosen);
AddSubcommand AddDevicesCommand, AddFeaturesCommand, AddSimulateCommand, AddRecordCommand, AddImportCommand,
    AddRepairCommand, AddBoardCommand, AddCalibrateCommand, AddCalibrationCommand, AddTrackCommand,
    AddRenderCommand, AddEvaluateCommand, AddMaskCommand, AddProxyCommand, AddViewCommand, AddPlanCommand,
    AddCaptureCommand, AddInfoCommand, AddSheetCommand, AddReviewCommand, AddTakeBackCommand,
    AddRefineCommand, AddExportCommand, AddMergeCommand;

// Returns a new subcommand and its arguments, for its options; choosing it sets `chosen` to `run` them.
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
