// Tracking: the size that pictures are tracked at, against the error of the poses and what a frame costs.
#include <fmt/format.h>

#include <limits>

#include "tests/charts/tracking/tracking_runs.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

// Pictures of one kind, their longer side, and how many runs there are of each size.
struct Pictures {
  std::string panel, series;
  TrackedCase tracked;
  int side_px = 0, runs = 1;
};

std::vector<Pictures> Kinds(const Effort& effort) {
  std::vector<Pictures> kinds;
  const auto add_real = [&](const std::string& recording, const std::vector<double>& factors) {
    for (const double factor : factors) {
      if (!HasRecording(recording)) return;
      TrackedCase tracked{recording, {.deterministic = true}, effort.Of(60, 120)};
      tracked.change.enlarged = factor;
      const int side_px = static_cast<int>(640 * factor);
      kinds.push_back({recording + ", enlarged", fmt::format("to {} px", side_px), tracked, side_px});
    }
  };
  const auto add_drawn = [&](const char* series, double blur_px, double noise) {
    TrackedCase tracked{kStudio, {.deterministic = true}, effort.Of(30, 100)};
    tracked.width = 1920;
    tracked.change.blur_px = blur_px;
    tracked.change.noise = noise;
    kinds.push_back({"simulator, drawn at 1,920 px", series, tracked, tracked.width, effort.Of(1, 2)});
  };
  add_real("handheld_kitchen", effort.Of(std::vector{4.0}, {1.0, 2.0, 4.0, 6.0}));
  add_real("scan_synthetic", effort.Of(std::vector<double>{}, {1.0, 4.0}));
  add_drawn("sharp", 0, 0);
  if (effort.quick) return kinds;
  add_drawn("noise of 12 grey levels", 0, 12);
  add_drawn("blurred by 4 px", 4, 0);
  return kinds;
}

// An error of the frames that were tracked says nothing where many were not.
constexpr double kTrackedShare = 0.7;
double ErrorOf(const TrackedRun& run) {
  return run.tracked_share < kTrackedShare ? std::numeric_limits<double>::infinity() : run.live_mm;
}

// Tracked at each size, and as they come.
std::vector<TrackedCase> AllSizes(const Pictures& pictures, const Effort& effort) {
  constexpr int kLargest = 3840;  // as they come; larger ones cost minutes
  constexpr int kDefault = TrackerOptions{}.max_side_px;
  std::vector<TrackedCase> cases;
  const auto add = [&](int side_px, bool full) {
    for (int run = 0; run < pictures.runs; ++run) {
      cases.push_back(pictures.tracked);
      cases.back().options.max_side_px = full ? 0 : side_px;
      cases.back().options.seed = kFirstSeed + static_cast<unsigned>(run);
      cases.back().name = full ? "full" : std::to_string(side_px);
      cases.back().is_default = full ? side_px <= kDefault : side_px == kDefault;
    }
  };
  for (const int side_px : effort.Of(std::vector{320, 640}, {320, 480, 640, 960, 1280, 1920, 2560}))
    if (side_px < pictures.side_px) add(side_px, false);
  if (pictures.side_px <= kLargest) add(pictures.side_px, true);
  return cases;
}

Chart MeasureSides(const Effort& effort) {
  Table table;
  std::vector<TrackedCase> cases;
  for (const Pictures& pictures : Kinds(effort))
    for (TrackedCase one : AllSizes(pictures, effort)) {
      one.panel = pictures.panel;
      one.series = pictures.series;
      cases.push_back(one);
    }
  const std::vector<TrackedRun> runs = TrackRuns(cases);
  for (const bool errors : {true, false})
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const TrackedCase& one = cases[i];
      const std::string title = one.panel + (errors ? ": error" : ": cost");
      table.Panel(title, Log("longer side of the tracked picture [px]"),
                  Log(errors ? "centres, live, RMS [mm]" : "a frame [times cv::ORB, CPU]"),
                  {.compared = false});
      const int whole_px = one.width == 640 ? static_cast<int>(640 * one.change.enlarged) : one.width;
      table.Add(title, one.series, one.name, one.options.max_side_px > 0 ? one.options.max_side_px : whole_px,
                errors ? ErrorOf(runs[i]) : runs[i].cpu_over_orb, one.is_default);
    }
  return {.panels = table.panels()};
}

CHART(tracking_side, MeasureSides,
      "The size that pictures are tracked at: error of live poses, and what a frame costs", R"(Names: longer
  side of the tracked picture, px; full: as they come. Recordings: the first 120 frames, 640 px wide,
  enlarged (cubic), one run each: on the kitchen differences of a fifth say nothing. Simulator: 100 frames,
  two seeds. The default was settled on both recordings and the sharp simulator; noise and blur report. No
  point: fewer than 70 % of the frames tracked. CPU of the tracking thread, reducing included, mapping
  apart, over cv::ORB with 1,000 features on the same pictures at 640 px.)");

}  // namespace
}  // namespace ulf::test
