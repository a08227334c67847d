#include "coverage/commands.h"

#include "coverage/capture_command.h"
#include "coverage/close_at_death.h"
#include "coverage/export_command.h"
#include "coverage/info_command.h"
#include "coverage/plan_command.h"
#include "coverage/refine_command.h"
#include "coverage/review_command.h"
#include "coverage/sheet_command.h"

namespace ulf {

void AddCoverageCommands(CLI::App& app, ChosenCommand& chosen) {
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
