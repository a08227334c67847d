// ulf merge merges the exposures of each view to one picture of linear light.

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <string>

#include "commands/options/subcommands.h"
#include "commands/reports/work_reports.h"
#include "core/base/error.h"
#include "core/base/json_text.h"

namespace ulf::commands {
namespace {

struct MergeArgs {
  std::string dir;
  bool json = false;
};

int RunMerge(const MergeArgs& args) {
  const render::BracketReport report = render::MergeBrackets(args.dir);
  if (report.views == 0 && report.left_out == 0)
    throw Error("{}: no view has other exposures; capture with --bracket, such as --bracket 3x2EV", args.dir);
  if (args.json)
    fmt::print("{}\n", JsonText(ToJson(report)));
  else
    fmt::print("{}", ToText(report));
  return report.views > 0 ? kOk : kFailed;
}

}  // namespace

void AddMergeCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [sub, args] = NewSubcommand(
      app, chosen, "merge",
      "Merges the exposures of each view (capture --bracket) to one picture of linear light", RunMerge);
  sub->add_option("dir", args->dir, "The light field")->required();
  sub->add_flag("--json", args->json, "Print one JSON object");
  sub->footer("After ulf proxy or ulf refine: better geometry and poses align the exposures better.");
}

}  // namespace ulf::commands
