#include "commands/commands.h"

#include "commands/capture/crash_handler.h"

namespace ulf::commands {

void AddCommands(CLI::App& app, ChosenCommand& chosen) {
  AddDevicesCommand(app, chosen);
  AddFeaturesCommand(app, chosen);
  AddSimulateCommand(app, chosen);
  AddRecordCommand(app, chosen);
  AddImportCommand(app, chosen);
  AddRepairCommand(app, chosen);
  AddBoardCommand(app, chosen);
  AddCalibrateCommand(app, chosen);
  AddCalibrationCommand(app, chosen);
  AddTrackCommand(app, chosen);
  AddRenderCommand(app, chosen);
  AddEvaluateCommand(app, chosen);
  AddMaskCommand(app, chosen);
  AddProxyCommand(app, chosen);
  AddViewCommand(app, chosen);
  AddPlanCommand(app, chosen);
  AddCaptureCommand(app, chosen);
  AddInfoCommand(app, chosen);
  AddTakeBackCommand(app, chosen);
  AddSheetCommand(app, chosen);
  AddReviewCommand(app, chosen);
  AddRefineCommand(app, chosen);
  AddCloseAfterCrashCommand(app, chosen);
  AddExportCommand(app, chosen);
  AddMergeCommand(app, chosen);
}

}  // namespace ulf::commands
