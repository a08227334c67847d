// Tracking: a focal length that is given wrong, or guessed, against where the right one would have ended.
#include <algorithm>

#include "tests/charts/makers.h"
#include "tests/charts/tracking/tracking_runs.h"
#include "tests/support/floors.h"

namespace ulf::test {

Chart LensChart(const ChartEffort& effort) {
  const std::vector<double> factors =
      effort.Of(std::vector{0.85, 1.0}, {0.5, 0.65, 0.75, 0.85, 0.95, 1.0, 1.05, 1.15, 1.3, 1.5});
  struct Use {
    const char* name;
    LensUse lens;
    bool is_guess;
  };
  const std::vector<Use> uses{{"as it is given", LensUse::kCheck, false},
                              {"a calibration, --intrinsics refine", LensUse::kRefine, false},
                              {"a guess, --intrinsics refine", LensUse::kRefine, true}};
  std::vector<TrackedCase> cases;
  for (const std::string recording : {kStudio, "handheld_kitchen", "scan_synthetic"}) {
    if (!HasRecording(recording)) continue;
    for (const Use& use : uses)
      for (const double factor : factors)
        for (const unsigned seed :
             IsSimulated(recording) ? effort.Of(std::vector{81u}, {81, 82, 83}) : std::vector{1u}) {
          TrackedCase one{recording, {.deterministic = true, .seed = seed}, effort.Of(60, 300)};
          one.options.lens = use.lens;
          one.options.lens_is_guess = use.is_guess;
          one.focal_factor = factor;
          cases.push_back(one);
        }
  }
  const std::vector<TrackedRun> runs = TrackRuns(cases);

  Chart chart;
  chart.title = "A wrong focal length: what is left of the error once the tracker has found the lens";
  chart.about =
      "The first 300 frames of recordings (simulator: studio, row_deg=4, seeds 81 to 83, 15 a second), "
      "tracked with the "
      "right focal length times a factor, and with no other knowledge of the lens. Without any calibration "
      "the guess is "
      "0.85 of the width: a factor of 0.97 in the simulator, 1.03 on the kitchen, 1.04 on the scan. Errors "
      "are RMS after "
      "the run and alignment. Infinite: not shown.";
  for (std::size_t i = 0; i < cases.size();) {
    const TrackedCase& one = cases[i];
    const std::string name = NameOf(one.recording);
    if (chart.panels.empty() || chart.panels.back().title != name)
      chart.panels.push_back({name,
                              {"focal length given / right", true},
                              {"centres, after the run, RMS [mm]", true},
                              {},
                              false});
    std::vector<double> errors;
    for (; i < cases.size() && cases[i].recording == one.recording &&
           cases[i].options.lens == one.options.lens &&
           cases[i].options.lens_is_guess == one.options.lens_is_guess &&
           cases[i].focal_factor == one.focal_factor;
         ++i)
      errors.push_back(runs[i].after_mm);
    chart.panels.back().points.push_back({std::find_if(uses.begin(), uses.end(),
                                                       [&](const Use& use) {
                                                         return use.lens == one.options.lens &&
                                                                use.is_guess == one.options.lens_is_guess;
                                                       })
                                              ->name,
                                          "", Spread::Exactly(one.focal_factor), Spread::Of(errors)});
  }
  return chart;
}

}  // namespace ulf::test
