#include "commands/capture/capture_start.h"

#include "acquisition/device/replay_device.h"
#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/simulated_device.h"
#include "commands/options/command_line.h"
#include "coverage/bound/capture_presets.h"

namespace ulf::commands {
namespace {

// Parses "60x40", "60x40:0.95", "60x40:95%" or "none".
void ParseUntilCovered(const std::string& text, coverage::CaptureOptions* options) {
  if (text.empty() || text == "none") return;
  const coverage::CapGoal goal = coverage::CapGoal::Parse(text);
  options->cap = goal.cap;
  if (goal.share) options->until_share = *goal.share;
}

// Refuses options that need the subject's sphere.
coverage::PhotographSpacing SpacingWithoutSubject(const CaptureArgs& args) {
  const CaptureArgs usual;
  const auto refuse = [](bool given, const char* option) {
    if (given)
      throw UsageError("--no-subject and {}: {} needs a subject to go round; leave out one of the two",
                       option, option);
  };
  refuse(!args.until_covered.empty() && args.until_covered != "none", "--until-covered");
  refuse(args.subject != usual.subject, "--subject");
  refuse(args.subject_size != usual.subject_size, "--subject-size");
  refuse(!args.quality.empty(), "--quality");
  refuse(args.threshold_px.has_value(), "--threshold-px");
  refuse(args.coverage_width_px.has_value(), "--coverage-width");
  refuse(!args.person.empty(), "--operator");
  refuse(!args.overlay.empty(), "--overlay");
  refuse(!args.map.empty(), "--map");
  refuse(args.cover != Name(coverage::CoverBy::kBound), "--cover");
  refuse(!args.error_map.empty(), "--error-map");
  if (!args.poses.UseFeatures())
    throw UsageError(
        "--no-subject and --poses {}: without a subject, tracked points tell how much a view adds, and these "
        "poses have none; leave out --poses, or give --subject x,y,z,radius in place of --no-subject",
        args.poses.Text());
  coverage::PhotographSpacing spacing;
  if (args.parallax_deg) spacing.parallax_deg = *args.parallax_deg;
  return spacing;
}

// Refuses options that a turntable excludes.
void RequireForTurntable(const CaptureArgs& args) {
  if (args.turntable.empty()) return;
  if (args.no_subject)
    throw UsageError("--turntable and --no-subject: what turns is the subject; leave out one of the two");
  if (args.cover != Name(coverage::CoverBy::kBound) || !args.error_map.empty())
    throw UsageError(
        "--turntable {}: errors are measured while the background is not masked yet; leave out --cover and "
        "--error-map",
        args.turntable);
}

}  // namespace

tracking::PosesSpec PosesFrom(const CaptureArgs& args) {
  if (args.turntable.empty()) return tracking::PosesSpec::Parse(args.poses_text);
  if (const CaptureArgs usual; args.poses_text != usual.poses_text)
    throw UsageError(
        "--turntable {0} and --poses {1}: the poses are the camera's about the board that turns; leave out "
        "--poses",
        args.turntable, args.poses_text);
  tracking::PosesSpec poses = tracking::PosesSpec::Parse("markers:" + args.turntable);
  if (poses.WorldVaries())
    throw UsageError(
        "--turntable {}: of several markers the first that is seen would be the world; give a board "
        "(charuco:5x5:54:40:DICT_4X4_50) or one marker's number ({}:0)",
        args.turntable, args.turntable);
  return poses;
}

coverage::CaptureOptions OptionsFrom(const CaptureArgs& args) {
  coverage::CaptureOptions options;
  RequireForTurntable(args);
  if (!args.turntable.empty()) options.turntable = args.poses.markers();
  if (args.parallax_deg && !args.no_subject)
    throw UsageError(
        "--parallax-deg {:g}: is the spacing of photographs without a subject; give --no-subject, too, or "
        "--quality or --threshold-px in its place",
        *args.parallax_deg);
  if (args.no_subject) options.without_subject = SpacingWithoutSubject(args);
  options.keep_apart = args.keep_apart;
  if (!args.bracket.empty()) options.bracket = coverage::ExposureBracket::Parse(args.bracket);
  ParseUntilCovered(args.until_covered, &options);
  if (!args.quality.empty() && args.threshold_px)
    throw UsageError("--quality {} and --threshold-px {} say the same thing twice; give one", args.quality,
                     *args.threshold_px);
  if (!args.quality.empty()) options.threshold_px = coverage::ThresholdOf(args.quality);
  if (args.threshold_px) options.threshold_px = *args.threshold_px;
  if (!(options.threshold_px > 2))
    throw UsageError("--threshold-px {}: the bound of a view with itself is 2 px; give more",
                     options.threshold_px);
  if (args.coverage_width_px) options.coverage_width_px = *args.coverage_width_px;
  if (options.coverage_width_px < 16)
    throw UsageError("--coverage-width {} is not the width of an image", options.coverage_width_px);
  if (!(args.subject_size > 0 && args.subject_size <= coverage::kRectangleShare))
    throw UsageError(
        "--subject-size {}: the sphere's share of the image's width, above 0 and at most {} (the safety "
        "rectangle)",
        args.subject_size, coverage::kRectangleShare);
  options.subject_size = args.subject_size;
  options.deterministic = args.deterministic;
  options.begins_on_request = !args.headless;
  options.checks_hold_start = !args.force_start;
  // For a turntable, geometry is made after the background is masked.
  options.geometry = !args.no_geometry && args.turntable.empty();
  options.cover = coverage::CoverGoal::Parse(args.cover);
  if (options.cover.by != coverage::CoverBy::kBound && args.no_geometry)
    throw UsageError("--cover {} and --no-geometry: errors are measured over the geometry; leave one out",
                     args.cover);
  if (!args.error_map.empty() && args.no_geometry)
    throw UsageError("--error-map and --no-geometry: errors are measured over the geometry; leave one out");
  options.max_frames = args.frames;
  options.max_seconds = args.max_seconds;
  if (args.subject != "auto") {
    if (!args.poses.DefineWorld() && !args.resume)
      throw UsageError(
          "--subject {}: the tracker has no world before it starts; use --subject auto, go on with a light "
          "field (--resume), or take poses whose world is known (--poses known, markers:, tum:, tcp:)",
          args.subject);
    options.subject = ParseSubject(args.subject);
  }
  return options;
}

bool PrepareCapture(const CaptureArgs& args, coverage::CaptureOptions* options,
                    PreparedCaptureCommand& hand) {
  coverage::SessionArgs session{.uri = args.uri,
                                .dir = args.dir,
                                .open = {},
                                .intrinsics = args.intrinsics,
                                .poses = args.poses,
                                .readout = args.readout,
                                .lens = args.lens,
                                .seeks_unknown_lens = !args.lens_is_asked,
                                .tracking_side_px = args.tracking_side_px,
                                .resume = args.resume,
                                .raw = args.raw,
                                .threshold_is_given = args.threshold_px || !args.quality.empty(),
                                .goal_is_given = !args.until_covered.empty()};
  session.open = [&]() -> std::unique_ptr<acquisition::Device> {
    if (args.person.empty())
      return acquisition::OpenDevice(acquisition::WithReplaySpeed(args.uri, args.speed));
    const DeviceUri uri = DeviceUri::Parse(args.uri);
    hand.person = coverage::MakeSimulatedOperator(uri, args.person);
    return acquisition::OpenSimulatedDevice(uri, hand.person);
  };
  return coverage::PrepareCapture(session, options, hand);
}

}  // namespace ulf::commands
