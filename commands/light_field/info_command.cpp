// ulf info: what a light field holds, in some ten lines.

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/commands.h"
#include "commands/light_field/light_field_report.h"
#include "core/light_field/light_field_io.h"

namespace ulf::commands {
namespace {

struct InfoArgs {
  std::string dir;
  std::string cap;
  std::string subject;
  std::optional<double> threshold_px;
  bool json = false;
};

int RunInfo(const InfoArgs& args) {
  ReportOptions options{.threshold_px = args.threshold_px};
  if (!args.cap.empty()) options.cap = coverage::Cap::ParseDegrees(args.cap);
  if (!args.subject.empty()) options.subject = ParseSubject(args.subject);
  const LightFieldReport report = Describe(ReadLightField(args.dir), options);
  fmt::print("{}", args.json ? ToJson(report).dump() + "\n" : ToText(report));
  return kOk;
}

}  // namespace

void AddInfoCommand(CLI::App& app, ChosenCommand& chosen) {
  auto args = std::make_shared<InfoArgs>();
  CLI::App* command =
      app.add_subcommand("info", "What a light field holds: views, time, angles, coverage, measured errors");
  command->add_option("DIR", args->dir, "Light field")->required();
  command->add_option(
      "--cap", args->cap,
      "Report coverage of this cap, AZIMUTHxELEVATION in degrees such as 60x40 (default: the goal of the "
      "capture)");
  command->add_option("--threshold-px", args->threshold_px,
                      "Largest error in pixels, for --cap (default: that of the capture, else 7)");
  command->add_option("--subject", args->subject,
                      "Subject: x,y,z,radius in world units (default: the light field's)");
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer("Example: ulf info my_light_field --cap 60x40");
  command->callback([args, &chosen] { chosen = [args] { return RunInfo(*args); }; });
}

}  // namespace ulf::commands
