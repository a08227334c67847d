#include "commands/capture/resume_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "commands/options/command_line.h"
#include "core/base/counted.h"
#include "core/base/shell_word.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/journal_stamp.h"

namespace ulf::commands {
namespace {

// Formats a subject as options take it.
std::string SubjectText(const Subject& subject) {
  const Eigen::Vector3d& center = subject.center_in_world;
  return fmt::format("{:.4g},{:.4g},{:.4g},{:.4g}", center.x(), center.y(), center.z(), subject.radius);
}

std::string SubjectRefusal(const CaptureArgs& args, const LightField& light_field) {
  if (args.subject != CaptureArgs().subject || !light_field.subject) return {};
  return fmt::format(
      " auto: none is looked for, because the light field has its subject, {}; leave it out, or give another "
      "(x,y,z,radius)",
      SubjectText(*light_field.subject));
}

std::string SubjectSizeRefusal(const CaptureArgs& args, const LightField& light_field) {
  const bool may_be_placed_anew = !args.headless || !args.requests.empty();
  if (!light_field.subject || may_be_placed_anew) return {};
  return fmt::format(
      " {:g}: no subject is looked for, because the light field has its own, {}; leave it out, or capture "
      "with the display, in which the subject can be placed anew",
      args.subject_size, SubjectText(*light_field.subject));
}

std::string NoSubjectRefusal(const CaptureArgs& /*args*/, const LightField& light_field) {
  if (!light_field.subject) return {};
  return fmt::format(
      ": the light field was captured round a subject, {}; leave it out, or begin a new light field",
      SubjectText(*light_field.subject));
}

// `given` is the text on the command line.
std::string ThresholdRefusal(const std::string& given, double threshold_px, const LightField& light_field) {
  if (!light_field.threshold_px || threshold_px == *light_field.threshold_px) return {};
  return fmt::format(
      " {}: the light field was begun with a threshold of {:g} px; leave it out, or begin a new light field",
      given, *light_field.threshold_px);
}

std::string QualityRefusal(const CaptureArgs& args, const LightField& light_field) {
  const double threshold_px = OptionsFrom(args).threshold_px;
  return ThresholdRefusal(fmt::format("{} ({:g} px)", args.quality, threshold_px), threshold_px, light_field);
}

std::string ThresholdPxRefusal(const CaptureArgs& args, const LightField& light_field) {
  return ThresholdRefusal(fmt::format("{:g}", *args.threshold_px), *args.threshold_px, light_field);
}

std::string CoverageWidthRefusal(const CaptureArgs& args, const LightField& light_field) {
  if (*args.coverage_width_px == light_field.coverage_width_px) return {};
  return fmt::format(" {}: the light field was begun with {}; leave it out, or begin a new light field",
                     *args.coverage_width_px, light_field.coverage_width_px);
}

std::string ForceCalibrationRefusal(const CaptureArgs& args, const LightField& /*light_field*/) {
  if (!args.intrinsics.calibration_path.empty()) return {};
  return ": the light field goes on under the lens that it has, and no file is read; give the file, too "
         "(calibration), or leave it out";
}

std::string WorldRefusal(const CaptureArgs& args, const std::string& given, const LightField& light_field) {
  const bool own_world = args.poses.DefineWorld() && !args.poses.ComeWithFrames();
  if (own_world && light_field.units != "metres")
    return fmt::format(
        " {}: its world is in metres, the light field's unit is arbitrary; leave it out, or begin a new "
        "light field",
        given);
  if (args.poses.WorldVaries())
    return fmt::format(
        " {0}: the first of several markers that is seen defines the world, and that may be another one now; "
        "give features, or the marker of the session before, which its end named ({0}:NUMBER)",
        given);
  return {};
}

std::string PosesRefusal(const CaptureArgs& args, const LightField& light_field) {
  return WorldRefusal(args, args.poses_text, light_field);
}

std::string TurntableRefusal(const CaptureArgs& args, const LightField& light_field) {
  if (const std::string world = WorldRefusal(args, args.turntable, light_field); !world.empty()) return world;
  if (!light_field.turntable && !light_field.views.empty())
    return fmt::format(
        " {}: the light field's subject stood still in its {}; leave it out, or begin a new light field",
        args.turntable, Counted(light_field.views.size(), "view"));
  const auto& markers = args.poses.markers();
  const std::string board = markers.kind == tracking::MarkerSpec::Kind::kBoard ? markers.board.Text() : "";
  if (!light_field.turntable || light_field.turntable->board == board) return {};
  return fmt::format(" {}: the light field's subject turned on {}; give that one, or begin a new light field",
                     args.turntable,
                     light_field.turntable->board.empty() ? "a single marker" : light_field.turntable->board);
}

// The tracker's map depends on the poses of the views, which belong to their lens.
std::string LensUseRefusal(const CaptureArgs& args, const LightField& light_field) {
  if (args.lens != tracking::LensUse::kRefine || light_field.views.empty()) return {};
  return fmt::format(
      " refine: the light field's {} hold the map under the lens that they were recorded with, which can "
      "only be checked; leave it out, and find another lens for all views together afterwards (ulf refine {} "
      "--intrinsics)",
      Counted(light_field.views.size(), "view"), ShellWord(args.dir));
}

std::string CalibrationOutRefusal(const CaptureArgs& /*args*/, const LightField& light_field) {
  if (light_field.views.empty()) return {};
  return fmt::format(": no lens is sought where a light field has views, and this one has {}; leave it out",
                     light_field.views.size());
}

// The rules are checked in this order.
constexpr ResumeRule kRules[] = {
    {"help", OnResume::kUsed},
    {"URI", OnResume::kUsedWithCamera},
    {"output", OnResume::kUsed},
    {"resume", OnResume::kUsed},
    {"follow-links", OnResume::kUsed},
    {"no-subject", OnResume::kMustAgree, NoSubjectRefusal},
    {"subject", OnResume::kCannotBeHonoured, SubjectRefusal},
    {"subject-size", OnResume::kCannotBeHonoured, SubjectSizeRefusal},
    {"parallax-deg", OnResume::kUsed},
    {"until-covered", OnResume::kUsed},
    {"quality", OnResume::kMustAgree, QualityRefusal},
    {"threshold-px", OnResume::kMustAgree, ThresholdPxRefusal},
    {"coverage-width", OnResume::kMustAgree, CoverageWidthRefusal},
    {"cover", OnResume::kUsed},
    // Another lens becomes a second camera: coverage/session/session_lenses.h.
    {"calibration", OnResume::kUsedWithCamera},
    {"focal-px", OnResume::kUsedWithCamera},
    {"force-calibration", OnResume::kCannotBeHonoured, ForceCalibrationRefusal},
    {"poses", OnResume::kMustAgree, PosesRefusal},
    {"turntable", OnResume::kMustAgree, TurntableRefusal},
    {"readout-ms", OnResume::kUsed},
    {"intrinsics", OnResume::kCannotBeHonoured, LensUseRefusal},
    {"calibration-out", OnResume::kCannotBeHonoured, CalibrationOutRefusal},
    {"tracking-side", OnResume::kUsed},
    {"frames", OnResume::kUsed},
    {"max-seconds", OnResume::kUsed},
    {"speed", OnResume::kUsed},
    {"bracket", OnResume::kUsed},
    {"keep-apart", OnResume::kUsed},
    {"keep-frames", OnResume::kUsed},
    {"requests", OnResume::kUsed},
    {"operator", OnResume::kUsed},
    {"headless", OnResume::kUsed},
    {"offscreen", OnResume::kUsed},
    {"marker", OnResume::kUsed},
    {"force-start", OnResume::kUsed},  // nothing contradicts it
    {"no-geometry", OnResume::kUsed},
    {"deterministic", OnResume::kUsed},
    {"raw", OnResume::kUsed},
    {"overlay", OnResume::kUsed},
    {"map", OnResume::kUsed},
    {"error-map", OnResume::kUsed},
    {"truth", OnResume::kUsed},
    {"json", OnResume::kUsed},
};

}  // namespace

std::span<const ResumeRule> ResumeRules() { return kRules; }

std::set<std::string> GivenOptions(const CLI::App& command) {
  std::set<std::string> given;
  for (const CLI::Option* option : command.get_options())
    if (option->count() > 0) given.insert(option->get_single_name());
  return given;
}

void RequireResumable(const CaptureArgs& args, const std::set<std::string>& given) {
  const std::filesystem::path journal = std::filesystem::path(args.dir) / kJournalFile;
  std::error_code unknown;
  if (!args.resume || !std::filesystem::is_regular_file(journal, unknown)) return;
  const LightField light_field = ReadJournal(journal).light_field;
  for (const ResumeRule& rule : kRules) {
    if (!rule.refusal || !given.contains(std::string(rule.option))) continue;
    const std::string why = rule.refusal(args, light_field);
    if (!why.empty()) throw UsageError("{}: --{}{}", args.dir, rule.option, why);
  }
}

}  // namespace ulf::commands
