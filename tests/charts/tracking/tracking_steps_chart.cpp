// Tracking: few frames a second. Every Nth frame of a recording is tracked.
#include "tests/charts/tracking/tracking_runs.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

Chart MeasureSteps(const Effort& effort) {
  Table table;
  const ChartAxis cost{"every Nth frame", true};
  table.Panel("frames with a pose", cost, MoreIsBetter({"share [%]"}), {.compared = false});
  for (const char* title : {"live", "after the run"})
    table.Panel(title, cost, Log("centres, RMS [mm]"), {.compared = false});
  std::vector<TrackedCase> cases;
  for (const std::string recording : {kStudio, "handheld_kitchen", "scan_synthetic"}) {
    if (!HasRecording(recording)) continue;
    for (const int every : effort.Of(std::vector{1, 10}, {1, 2, 5, 10, 15, 20}))
      for (const int run : effort.Of(std::vector{0}, {0, 1, 2})) {
        TrackedCase one{recording,
                        {.deterministic = true, .seed = kFirstSeed},
                        effort.Of(60, IsSimulated(recording) ? 300 : 100000)};
        one.every = every;
        one.first = StartOf(run, every);
        cases.push_back(one);
      }
  }
  const std::vector<TrackedRun> runs = TrackRuns(cases);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string series = NameOf(cases[i].recording);
    table.Add("frames with a pose", series, "", cases[i].every, 100 * runs[i].tracked_share);
    table.Add("live", series, "", cases[i].every, runs[i].live_mm);
    table.Add("after the run", series, "", cases[i].every, runs[i].after_mm);
  }
  return {.panels = table.panels()};
}

CHART(tracking_steps, MeasureSteps,
      "Few frames a second: what becomes of poses when frames lie farther apart", R"(Every Nth frame of
  recordings of 30 frames a second (simulator: studio, row_deg=4, 300 frames, 15 a second), begun at three
  of N frames. Shares are of the frames that were shown, the start included. Errors are RMS after alignment;
  the kitchen has a reference in every twelfth frame. Bars: lowest to highest.)");

}  // namespace
}  // namespace ulf::test
