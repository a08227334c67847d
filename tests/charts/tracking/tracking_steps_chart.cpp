// Tracking: few frames a second. Every Nth frame of a recording is tracked.
#include "tests/charts/makers.h"
#include "tests/charts/tracking/tracking_runs.h"
#include "tests/support/floors.h"

namespace ulf::test {

Chart TrackingStepsChart(const ChartEffort& effort) {
  const std::vector<int> steps = effort.Of(std::vector{1, 10}, {1, 2, 5, 10, 15, 20});
  std::vector<TrackedCase> cases;
  for (const std::string recording : {kStudio, "handheld_kitchen", "scan_synthetic"}) {
    if (!HasRecording(recording)) continue;
    const int frames = IsSimulated(recording) ? 300 : 100000;
    for (const int every : steps)
      for (const int run : effort.Of(std::vector{0}, {0, 1, 2})) {
        TrackedCase one{recording, {.deterministic = true}, effort.Of(60, frames)};
        one.options.seed = IsSimulated(recording) ? 71 : 1;
        one.every = every;
        one.first = StartOf(run, every);
        cases.push_back(one);
      }
  }
  const std::vector<TrackedRun> runs = TrackRuns(cases);

  Chart chart;
  chart.title = "Few frames a second: what becomes of poses when frames lie farther apart";
  chart.about =
      "Every Nth frame of recordings of 30 frames a second (simulator: studio, row_deg=4, seed 71, 300 "
      "frames, 15 a "
      "second), begun at three of N frames. Shares are of the frames that were shown, the start "
      "included. Errors are RMS after alignment; the kitchen has a reference in every twelfth frame. Bars: "
      "lowest to "
      "highest.";
  ChartPanel share{"frames with a pose", {"every Nth frame", true}, {"share [%]", false, true}, {}, false};
  ChartPanel live{"live", {"every Nth frame", true}, {"centres, RMS [mm]", true}, {}, false};
  ChartPanel after{"after the run", {"every Nth frame", true}, {"centres, RMS [mm]", true}, {}, false};
  for (std::size_t i = 0; i < cases.size();) {
    const TrackedCase& one = cases[i];
    std::vector<double> shares, lives, afters;
    for (; i < cases.size() && cases[i].recording == one.recording && cases[i].every == one.every; ++i) {
      shares.push_back(100 * runs[i].tracked_share);
      lives.push_back(runs[i].live_mm);
      afters.push_back(runs[i].after_mm);
    }
    const Spread step = Spread::Exactly(one.every);
    share.points.push_back({NameOf(one.recording), "", step, Spread::Of(shares)});
    live.points.push_back({NameOf(one.recording), "", step, Spread::Of(lives)});
    after.points.push_back({NameOf(one.recording), "", step, Spread::Of(afters)});
  }
  chart.panels = {share, live, after};
  return chart;
}

}  // namespace ulf::test
