// Declares the subcommands: each has a file of its name in a room of commands/ that parses, calls one
// function, and prints. A function adds its subcommand to the program's command line and, if the user chose
// it, sets `chosen` to the function to run.
#pragma once

#include "commands/options/command_line.h"

namespace ulf::commands {

// Adds all, in the order of the help.
void AddCommands(CLI::App& app, ChosenCommand& chosen);

void AddDevicesCommand(CLI::App& app, ChosenCommand& chosen);
void AddFeaturesCommand(CLI::App& app, ChosenCommand& chosen);
void AddSimulateCommand(CLI::App& app, ChosenCommand& chosen);
void AddRecordCommand(CLI::App& app, ChosenCommand& chosen);
void AddImportCommand(CLI::App& app, ChosenCommand& chosen);
void AddRepairCommand(CLI::App& app, ChosenCommand& chosen);
void AddBoardCommand(CLI::App& app, ChosenCommand& chosen);
void AddCalibrateCommand(CLI::App& app, ChosenCommand& chosen);
void AddCalibrationCommand(CLI::App& app, ChosenCommand& chosen);
void AddTrackCommand(CLI::App& app, ChosenCommand& chosen);
void AddRenderCommand(CLI::App& app, ChosenCommand& chosen);
void AddEvaluateCommand(CLI::App& app, ChosenCommand& chosen);
void AddMaskCommand(CLI::App& app, ChosenCommand& chosen);
void AddProxyCommand(CLI::App& app, ChosenCommand& chosen);
void AddViewCommand(CLI::App& app, ChosenCommand& chosen);
void AddPlanCommand(CLI::App& app, ChosenCommand& chosen);
void AddCaptureCommand(CLI::App& app, ChosenCommand& chosen);
void AddInfoCommand(CLI::App& app, ChosenCommand& chosen);
void AddSheetCommand(CLI::App& app, ChosenCommand& chosen);
void AddReviewCommand(CLI::App& app, ChosenCommand& chosen);
void AddTakeBackCommand(CLI::App& app, ChosenCommand& chosen);
void AddRefineCommand(CLI::App& app, ChosenCommand& chosen);
void AddExportCommand(CLI::App& app, ChosenCommand& chosen);
void AddMergeCommand(CLI::App& app, ChosenCommand& chosen);

}  // namespace ulf::commands
