// Declares the subcommands: each has a file of its name in a room of commands/ that parses, calls one
// function, and prints. A function adds its subcommand to the program's command line and, if the user chose
// it, sets `chosen` to the function to run.
#pragma once

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

}  // namespace ulf::commands
