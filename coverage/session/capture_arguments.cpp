#include "coverage/session/capture_arguments.h"

#include <cstdio>

#include "core/base/error.h"

namespace ulf::coverage {
namespace {

// "60x40", "60x40:0.95", "60x40:95%" or "none".
void ParseUntilCovered(const std::string& text, CaptureOptions* options) {
  if (text.empty() || text == "none") return;
  const CapGoal goal = CapGoal::Parse(text);
  options->cap = goal.cap;
  if (goal.share) options->until_share = *goal.share;
}

// What measures by a subject's sphere has nothing to measure without one.
PhotographSpacing SpacingWithoutSubject(const CaptureArgs& args) {
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
  if (!args.poses.UseFeatures())
    throw UsageError(
        "--no-subject and --poses {}: how much a view adds is told by tracked points, which these poses do "
        "without; leave out --poses, or give --subject x,y,z,radius in place of --no-subject",
        args.poses.Text());
  PhotographSpacing spacing;
  if (args.parallax_deg) spacing.parallax_deg = *args.parallax_deg;
  return spacing;
}

}  // namespace

CaptureOptions OptionsFrom(const CaptureArgs& args) {
  CaptureOptions options;
  if (args.parallax_deg && !args.no_subject)
    throw UsageError(
        "--parallax-deg {:g}: is the spacing of photographs without a subject; give --no-subject, too, or "
        "--quality or --threshold-px in its place",
        *args.parallax_deg);
  if (args.no_subject) options.without_subject = SpacingWithoutSubject(args);
  ParseUntilCovered(args.until_covered, &options);
  if (!args.quality.empty() && args.threshold_px)
    throw UsageError("--quality {} and --threshold-px {} say the same thing twice; give one", args.quality,
                     *args.threshold_px);
  if (args.quality == "fast") options.threshold_px = 12;
  if (args.threshold_px) options.threshold_px = *args.threshold_px;
  if (!(options.threshold_px > 2))
    throw UsageError("--threshold-px {}: the bound of a view with itself is 2 px; give more",
                     options.threshold_px);
  if (args.coverage_width_px) options.coverage_width_px = *args.coverage_width_px;
  if (options.coverage_width_px < 16)
    throw UsageError("--coverage-width {} is not the width of an image", options.coverage_width_px);
  if (!(args.subject_size > 0 && args.subject_size <= 0.8))
    throw UsageError(
        "--subject-size {}: the sphere's share of the image's width, above 0 and at most 0.8 (the "
        "safety rectangle)",
        args.subject_size);
  options.subject_size = args.subject_size;
  options.deterministic = args.deterministic;
  options.max_frames = args.frames;
  options.max_seconds = args.max_seconds;
  if (args.subject != "auto") {
    if (!args.poses.HaveAWorld() && !args.resume)
      throw UsageError(
          "--subject {}: the tracker's world does not exist before it has begun; use --subject auto, go on "
          "with a "
          "light field (--resume), or take poses whose world is known (--poses known, markers:, tum:, tcp:)",
          args.subject);
    options.subject = ParseSubject(args.subject);
  }
  return options;
}

}  // namespace ulf::coverage
