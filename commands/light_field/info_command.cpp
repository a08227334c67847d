// ulf info describes a light field in some ten lines; several in a table with a row for each.

#include <fmt/core.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "commands/options/command_line.h"
#include "commands/options/subcommands.h"
#include "commands/reports/check_reports.h"
#include "commands/reports/geometry_report.h"
#include "commands/reports/light_field_report.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/progress.h"
#include "core/base/shell_word.h"
#include "core/light_field/exchange/conversions.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/journal_stamp.h"

namespace ulf::commands {
namespace {

struct InfoArgs {
  std::vector<std::string> dirs;
  std::string cap;
  std::string subject;
  std::optional<double> threshold_px;
  bool check_poses = false, check_light = false;
  bool json = false;
};

// A capture writes these files when it ends: a killed or running one has none or older ones.
std::string MissingForOthersText(const LightField& light_field) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  const auto is_there = [&](const char* name) { return fs::exists(light_field.root / name, unknown); };
  if (!is_there(kJournalFile) || (is_there(kTransformsFile) && is_there("sparse/0"))) return {};
  return fmt::format(
      "for others     no transforms.json or sparse/0 yet: they are written when a capture ends; where it was "
      "killed, 'ulf repair {} --write' writes them\n",
      ShellWord(light_field.root.string()));
}

// Prints a row of each, like the thesis's Table 6.1. Unreadable ones are listed after the others.
int RunInfoOfSeveral(const InfoArgs& args, const ReportOptions& options) {
  if (args.check_poses || args.check_light)
    throw UsageError("{}: looks at one light field at a time; give one folder",
                     args.check_poses ? "--check-poses" : "--check-light");
  if (!args.subject.empty())
    throw UsageError("--subject {}: each light field has its own; give one folder", args.subject);
  std::vector<NamedReport> reports;
  std::string problems;
  for (const std::string& dir : args.dirs) try {
      reports.push_back({dir, Describe(ReadLightField(dir), options)});
    } catch (const Error& error) {
      problems += (problems.empty() ? "" : "\n") + std::string(error.what());
    }
  if (args.json)
    fmt::print("{}\n", JsonText(TableJson(reports)));
  else
    fmt::print("{}", TableText(reports));
  if (!problems.empty()) throw Error("{}", problems);
  return kOk;
}

int RunInfo(const InfoArgs& args) {
  ReportOptions options{.threshold_px = args.threshold_px};
  if (!args.cap.empty()) options.cap = coverage::Cap::ParseDegrees(args.cap);
  if (!args.subject.empty()) options.subject = ParseSubject(args.subject);
  if (args.dirs.size() > 1) return RunInfoOfSeveral(args, options);
  LightField light_field = ReadLightField(args.dirs[0]);
  const LightFieldReport report = Describe(light_field, options);
  const std::optional<render::GeometryState> geometry = render::GeometryStateOf(light_field);
  std::optional<PoseReport> poses;
  if (args.check_poses) poses = CheckedPoses(light_field, args.json);
  std::optional<LightCheck> light;
  if (args.check_light) {
    Progress progress("light", args.json);
    light = CheckLightOf(light_field, progress);
    if (light->not_compared.empty()) KeepLight(*light, light_field);
  }
  if (args.json) {
    nlohmann::json json = ToJson(report);
    json["geometry"] = GeometryJson(geometry);
    json["doubts"] = DoubtsJson(light_field);
    if (poses) json["poses"] = ToJson(*poses, light_field);
    if (light) json["light"] = ToJson(*light);
    if (light)
      for (const Conversion& conversion : ConversionsOf(light_field))
        json["light"]["conversions"].push_back(
            {{"photograph", conversion.file.lexically_relative(light_field.root).generic_string()},
             {"words", conversion.words}});
    fmt::print("{}\n", JsonText(json));
  } else {
    fmt::print("{}{}{}{}{}", ToText(report), GeometryText(geometry, light_field),
               MissingForOthersText(light_field), poses ? ToText(*poses, light_field) : "",
               light ? ToText(*light, SourceOf(light_field)) : "");
  }
  return kOk;
}

}  // namespace

void AddInfoCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] =
      NewSubcommand(app, chosen, "info",
                    "What a light field holds: views, time, angles, coverage, measured errors", RunInfo);
  command
      ->add_option("DIR", args->dirs,
                   "Light field; of several, a table with a row for each: views, minutes, angular range, "
                   "angle between neighbours")
      ->required();
  command->add_option("--cap", args->cap,
                      "Report coverage of this cap, AZIMUTHxELEVATION in degrees such as 60x40 (default: the "
                      "goal of the capture)");
  command->add_option("--threshold-px", args->threshold_px,
                      "Largest error in pixels, for --cap (default: that of the capture, else 7)");
  command->add_option("--subject", args->subject,
                      "Subject: x,y,z,radius in world units (default: the light field's)");
  command->add_flag("--check-poses", args->check_poses,
                    "Also compare the pictures: list views whose poses their neighbours contradict");
  command->add_flag("--check-light", args->check_light,
                    "Also read the photographs: how much is clipped, and whether the lamp changed between "
                    "earlier and later views");
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer("Example: ulf info my_light_field --cap 60x40\n         ulf info vase jar bust");
}

}  // namespace ulf::commands
