// Tracking: the size that pictures are tracked at, against the error of the poses and what a frame costs.
#include <limits>

#include "tests/charts/makers.h"
#include "tests/charts/tracking/tracking_runs.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

// Pictures of one kind, their longer side, and how many runs there are of each size.
struct Pictures {
  std::string panel, series;
  TrackedCase tracked;
  int side_px = 0, runs = 1;
};

std::vector<Pictures> Kinds(const ChartEffort& effort) {
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

// Pictures of one kind tracked at one size; the first of its runs.
struct Tried {
  Pictures pictures;
  int side_px = 0;
  bool full = false;
  std::size_t first_run = 0;

  std::string Name() const { return full ? "full" : std::to_string(side_px); }
  bool IsDefault() const {
    return full ? side_px <= TrackerOptions{}.max_side_px : side_px == TrackerOptions{}.max_side_px;
  }
};

std::vector<Tried> AllSizes(const ChartEffort& effort) {
  constexpr int kLargest = 3840;  // as they come; larger ones cost minutes
  std::vector<Tried> tried;
  std::size_t runs = 0;
  const auto add = [&](const Pictures& pictures, int side_px, bool full) {
    tried.push_back({pictures, side_px, full, runs});
    runs += static_cast<std::size_t>(pictures.runs);
  };
  for (const Pictures& pictures : Kinds(effort)) {
    for (const int side_px : effort.Of(std::vector{320, 640}, {320, 480, 640, 960, 1280, 1920, 2560}))
      if (side_px < pictures.side_px) add(pictures, side_px, false);
    if (pictures.side_px <= kLargest) add(pictures, pictures.side_px, true);
  }
  return tried;
}

std::vector<TrackedRun> TrackAll(const std::vector<Tried>& tried) {
  std::vector<TrackedCase> cases;
  for (const Tried& one : tried)
    for (int run = 0; run < one.pictures.runs; ++run) {
      cases.push_back(one.pictures.tracked);
      cases.back().options.max_side_px = one.full ? 0 : one.side_px;
      cases.back().options.seed = 61 + static_cast<unsigned>(run);
    }
  return TrackRuns(cases);
}

// An error of the frames that were tracked says nothing where many were not.
constexpr double kTrackedShare = 0.7;
double ErrorOf(const TrackedRun& run) {
  return run.tracked_share < kTrackedShare ? std::numeric_limits<double>::infinity() : run.live_mm;
}

}  // namespace

Chart TrackingSideChart(const ChartEffort& effort) {
  const std::vector<Tried> tried = AllSizes(effort);
  const std::vector<TrackedRun> runs = TrackAll(tried);
  Chart chart;
  chart.title = "The size that pictures are tracked at: error of live poses, and what a frame costs";
  chart.about = fmt::format(
      "Names: longer side of the tracked picture, px; full: as they come. Recordings: the first 120 frames, "
      "640 px wide, enlarged (cubic), one run each: on the kitchen differences of a fifth say nothing. "
      "Simulator: 100 frames, seeds 61 and 62. The default was settled on both recordings and the "
      "sharp simulator; noise and blur report. No point: fewer than {:.0f} % of the frames tracked. CPU of "
      "the "
      "tracking thread, reducing included, mapping apart, over cv::ORB with 1,000 features on the same "
      "pictures at 640 px.",
      100 * kTrackedShare);
  for (const bool errors : {true, false})
    for (const Tried& one : tried) {
      const std::string title = one.pictures.panel + (errors ? ": error" : ": cost");
      if (chart.panels.empty() || chart.panels.back().title != title)
        chart.panels.push_back({title,
                                {"longer side of the tracked picture [px]", true},
                                {errors ? "centres, live, RMS [mm]" : "a frame [times cv::ORB, CPU]", true},
                                {},
                                false});
      std::vector<double> values;
      for (std::size_t run = 0; run < static_cast<std::size_t>(one.pictures.runs); ++run)
        values.push_back(errors ? ErrorOf(runs[one.first_run + run])
                                : runs[one.first_run + run].cpu_over_orb);
      chart.panels.back().points.push_back({one.pictures.series, one.Name(), Spread::Exactly(one.side_px),
                                            Spread::Of(values), one.IsDefault()});
    }
  return chart;
}

}  // namespace ulf::test
