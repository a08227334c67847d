// ulf repair repairs a light field's folder, first as a plan.

#include <nlohmann/json.hpp>

#include "commands/options/subcommands.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/light_field/folder/repair_plan.h"
#include "render/proxy/mesh_file.h"

namespace ulf::commands {
namespace {

struct RepairArgs {
  std::string dir;
  bool write = false;
  bool json = false;
};

void PrintText(const RepairPlan& plan, const RepairArgs& args) {
  for (const std::string& each : plan.found) fmt::print("found: {}\n", each);
  if (!plan.any() && plan.not_done.empty()) {
    fmt::print("{}: {}, {}\n", args.dir, Counted(plan.views_before, "view"),
               plan.found.empty() ? "nothing to repair" : "nothing that can be repaired");
    return;
  }
  for (const std::string& each : plan.steps) fmt::print("{} {}\n", args.write ? "did this:" : "would", each);
  for (const std::string& each : plan.not_done) fmt::print("not done: {}\n", each);
  fmt::print("{}: {} before, {} {}\n", args.dir, Counted(plan.views_before, "view"), plan.views_after,
             args.write
                 ? "now"
                 : "after 'ulf repair " + ShellWord(args.dir) + " --write'; nothing has been changed yet");
}

// The mesh follows from the views: ulf proxy makes it again.
void CheckMesh(const std::filesystem::path& dir, RepairPlan& plan) {
  const std::filesystem::path mesh = dir / render::kMeshProxyFile;
  try {
    if (std::filesystem::exists(mesh)) render::ReadMeshFile(mesh);
  } catch (const Error& error) {
    plan.found.push_back(fmt::format("{}; '{}' makes it again", error.what(), render::ProxyCommand(dir)));
  }
}

int RunRepair(const RepairArgs& args) {
  RepairPlan plan = args.write ? Repair(args.dir) : PlanRepair(args.dir);
  CheckMesh(args.dir, plan);
  if (args.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"found", plan.found},
                                              {"steps", plan.steps},
                                              {"not_done", plan.not_done},
                                              {"views_before", plan.views_before},
                                              {"views_after", plan.views_after},
                                              {"written", args.write && plan.any()}}
                           .dump(2));
  else
    PrintText(plan, args);
  return plan.not_done.empty() ? kOk : kFailed;
}

}  // namespace

void AddRepairCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "repair", "Put a light field's folder in order; says first what it would do", RunRepair);
  command->add_option("DIR", args->dir, "Light field")->required();
  command->add_flag("--write,--apply,--yes", args->write,
                    "Repair (default: only report what would be done); replaced files are kept in DIR/kept");
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer("Example: ulf repair vase --write");
}

}  // namespace ulf::commands
