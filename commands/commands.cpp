#include "commands/commands.h"

#include "commands/calibration/board_command.h"
#include "commands/calibration/calibrate_command.h"
#include "commands/calibration/calibration_command.h"
#include "commands/camera/devices_command.h"
#include "commands/camera/features_command.h"
#include "commands/camera/record_command.h"
#include "commands/camera/simulate_command.h"
#include "commands/capture/capture_command.h"
#include "commands/capture/crash_handler.h"
#include "commands/capture/plan_command.h"
#include "commands/light_field/export_command.h"
#include "commands/light_field/import_command.h"
#include "commands/light_field/info_command.h"
#include "commands/light_field/repair_command.h"
#include "commands/light_field/sheet_command.h"
#include "commands/rendering/evaluate_command.h"
#include "commands/rendering/proxy_command.h"
#include "commands/rendering/render_command.h"
#include "commands/rendering/review_command.h"
#include "commands/rendering/view_command.h"
#include "commands/tracking/refine_command.h"
#include "commands/tracking/track_command.h"

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
  AddProxyCommand(app, chosen);
  AddViewCommand(app, chosen);
  AddPlanCommand(app, chosen);
  AddCaptureCommand(app, chosen);
  AddInfoCommand(app, chosen);
  AddSheetCommand(app, chosen);
  AddReviewCommand(app, chosen);
  AddRefineCommand(app, chosen);
  AddCloseAfterCrashCommand(app, chosen);
  AddExportCommand(app, chosen);
}

}  // namespace ulf::commands
