#include "commands/options/subcommands.h"

#include <vector>

#include "commands/capture/crash_handler.h"
#include "core/light_field/folder/followed_links.h"

namespace ulf::commands {

namespace {

// Every command that opens a light field has an option that permits the links in its folder.
void AddFollowLinks(CLI::App& app) {
  for (const char* name :
       {"capture", "record", "track", "calibrate", "plan", "import", "info", "render", "evaluate", "view",
        "review", "refine", "proxy", "mask", "merge", "repair", "take-back", "sheet", "export"}) {
    CLI::App* command = app.get_subcommand(name);
    std::vector<CLI::App*> all = command->get_subcommands({});
    if (all.empty()) all = {command};
    for (CLI::App* each : all)
      each->add_flag_callback(
          "--follow-links", [] { FollowOutsideLinks(); },
          "Follow links in the light field's folder to other folders of the same owner, now and from now on "
          "(kept in DIR/links.json)");
  }
}

}  // namespace

void AddCommands(CLI::App& app, ChosenCommand& chosen) {
  for (AddSubcommand* add : {AddDevicesCommand,  AddFeaturesCommand,        AddSimulateCommand,
                             AddRecordCommand,   AddImportCommand,          AddRepairCommand,
                             AddBoardCommand,    AddCalibrateCommand,       AddCalibrationCommand,
                             AddTrackCommand,    AddRenderCommand,          AddEvaluateCommand,
                             AddMaskCommand,     AddProxyCommand,           AddViewCommand,
                             AddPlanCommand,     AddCaptureCommand,         AddInfoCommand,
                             AddTakeBackCommand, AddSheetCommand,           AddReviewCommand,
                             AddRefineCommand,   AddCloseAfterCrashCommand, AddExportCommand,
                             AddMergeCommand})
    add(app, chosen);
  AddFollowLinks(app);
}

}  // namespace ulf::commands
