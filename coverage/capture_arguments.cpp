#include "coverage/capture_arguments.h"

#include <cstdio>

#include "acquisition/error.h"
#include "acquisition/import_export.h"

namespace ulf {
namespace {

// "60x40", "60x40:0.95", "60x40:95%" or "none".
void ParseUntilCovered(const std::string& text, CaptureOptions* options) {
  if (text.empty() || text == "none") return;
  const CapGoal goal = CapGoal::Parse(text);
  options->cap = goal.cap;
  if (goal.share) options->until_share = *goal.share;
}

}  // namespace

CaptureOptions OptionsFrom(const CaptureArgs& args) {
  CaptureOptions options;
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

}  // namespace ulf
