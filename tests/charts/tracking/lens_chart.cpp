// Tracking: a focal length that is given wrong, or guessed, against where the right one would have ended.
#include "tests/charts/tracking/tracking_runs.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

Chart MeasureLenses(const Effort& effort) {
  struct Use {
    const char* name;
    LensUse lens;
    bool is_guess;
  };
  Table table;
  std::vector<TrackedCase> cases;
  for (const std::string recording : {kStudio, "handheld_kitchen", "scan_synthetic"}) {
    if (!HasRecording(recording)) continue;
    table.Panel(NameOf(recording), Log("focal length given / right"), Log("centres, after the run, RMS [mm]"),
                {.compared = false});
    for (const Use& use : {Use{"as it is given", LensUse::kCheck, false},
                           {"a calibration, --intrinsics refine", LensUse::kRefine, false},
                           {"a guess, --intrinsics refine", LensUse::kRefine, true}})
      for (const double factor :
           effort.Of(std::vector{0.85, 1.0}, {0.5, 0.65, 0.75, 0.85, 0.95, 1.0, 1.05, 1.15, 1.3, 1.5}))
        for (const unsigned seed : IsSimulated(recording) ? effort.Seeds(3) : std::vector{1u}) {
          TrackedCase one{recording, {.deterministic = true, .seed = seed}, effort.Of(60, 300)};
          one.options.lens = use.lens;
          one.options.lens_is_guess = use.is_guess;
          one.focal_factor = factor;
          one.panel = NameOf(recording);
          one.series = use.name;
          cases.push_back(one);
        }
  }
  const std::vector<TrackedRun> runs = TrackRuns(cases);
  for (std::size_t i = 0; i < cases.size(); ++i)
    table.Add(cases[i].panel, cases[i].series, "", cases[i].focal_factor, runs[i].after_mm);
  return {.panels = table.panels()};
}

CHART(lens, MeasureLenses,
      "A wrong focal length: what is left of the error once the tracker has found the lens", R"(The first
  300 frames of recordings (simulator: studio, row_deg=4, three seeds, 15 a second), tracked with the right
  focal length times a factor, and with no other knowledge of the lens. Without any calibration the guess is
  0.85 of the width: a factor of 0.97 in the simulator, 1.03 on the kitchen, 1.04 on the scan. Errors are
  RMS after the run and alignment. Infinite: not shown.)");

}  // namespace
}  // namespace ulf::test
