#include "acquisition/commands.h"

#include "acquisition/calibration/board_command.h"
#include "acquisition/calibration/calibrate_command.h"
#include "acquisition/calibration/calibration_command.h"
#include "acquisition/devices_command.h"
#include "acquisition/features_command.h"
#include "acquisition/import_command.h"
#include "acquisition/record_command.h"
#include "acquisition/repair_command.h"
#include "acquisition/simulator/simulate_command.h"

namespace ulf {

void AddAcquisitionCommands(CLI::App& app, ChosenCommand& chosen) {
  AddDevicesCommand(app, chosen);
  AddFeaturesCommand(app, chosen);
  AddSimulateCommand(app, chosen);
  AddRecordCommand(app, chosen);
  AddImportCommand(app, chosen);
  AddRepairCommand(app, chosen);
  AddBoardCommand(app, chosen);
  AddCalibrateCommand(app, chosen);
  AddCalibrationCommand(app, chosen);
}

}  // namespace ulf
