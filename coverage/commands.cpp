#include "coverage/commands.h"

#include "acquisition/calibration/board_command.h"
#include "acquisition/calibration/calibrate_command.h"
#include "acquisition/calibration/calibration_command.h"
#include "acquisition/devices_command.h"
#include "acquisition/features_command.h"
#include "acquisition/import_command.h"
#include "acquisition/record_command.h"
#include "acquisition/repair_command.h"
#include "acquisition/simulator/simulate_command.h"
#include "coverage/capture_command.h"
#include "coverage/close_at_death.h"
#include "coverage/export_command.h"
#include "coverage/info_command.h"
#include "coverage/plan_command.h"
#include "coverage/refine_command.h"
#include "coverage/review_command.h"
#include "coverage/sheet_command.h"
#include "render/evaluate_command.h"
#include "render/render_command.h"
#include "render/stereo/proxy_command.h"
#include "render/viewer/view_command.h"
#include "tracking/track_command.h"

namespace ulf {

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
  AddCloseAfterDeathCommand(app, chosen);
  AddExportCommand(app, chosen);
}

}  // namespace ulf
