// Tracking: pyramid levels that corners are detected on, where the camera goes nearer and farther, where it
// does not, in pictures that are soft, and with few frames a second.
#include <fmt/format.h>

#include "tests/charts/tracking/tracking_runs.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct Situation {
  std::string panel, series;
  TrackedCase tracked;
};

std::vector<Situation> Situations(const Effort& effort) {
  std::vector<Situation> situations;
  const auto add = [&](const char* panel, const char* series, const char* recording, int frames,
                       auto&& change) {
    if (!HasRecording(recording)) return;
    situations.push_back({panel, series, {recording, {.deterministic = true}, effort.Of(60, frames)}});
    change(situations.back().tracked);
  };
  constexpr int kFrames = 300, kAll = 100000;
  const auto as_it_is = [](TrackedCase&) {};
  const char* const few = "every 10th frame";
  const auto sparse = [](TrackedCase& one) { one.every = 10; };
  add(few, "studio, 0.5 to 2 times as far", "sim:studio?dolly=2&row_deg=4", 360, sparse);
  if (effort.quick) return situations;
  add(few, "kitchen", "handheld_kitchen", kAll, sparse);
  const char* const soft = "soft";
  const auto blurred = [](TrackedCase& one) { one.change.blur_px = 2; };
  add(soft, "kitchen, blurred by 2 px", "handheld_kitchen", kFrames, blurred);
  const char* const alike = "always about as far away";
  add(alike, "studio", kStudio, 200, as_it_is);
  add(alike, "scan_synthetic", "scan_synthetic", kFrames, as_it_is);
  const char* const near_and_far = "nearer and farther";
  add(near_and_far, "studio, 0.5 to 2 times as far", "sim:studio?dolly=2&row_deg=4", 360, as_it_is);
  return situations;
}

// Over those of the first number of levels.
void AddLevels(const Situation& situation, const Effort& effort, Table& table) {
  const std::vector<int> levels = effort.Of(std::vector{8, 3}, {8, 5, 4, 3});
  std::vector<TrackedCase> cases;
  for (const int count : levels)
    for (TrackedCase& one : Repeated(situation.tracked, effort)) {
      one.options.corners.levels = count;
      cases.push_back(one);
    }
  const std::vector<TrackedRun> runs = TrackRuns(cases);
  const std::size_t each = runs.size() / levels.size();
  double usual_cost = 1, usual_error = 1;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const auto spread = [&](double TrackedRun::*value) {
      std::vector<double> values;
      for (std::size_t run = 0; run < each; ++run) values.push_back(runs[i * each + run].*value);
      return Spread::Of(values);
    };
    const Spread cost = spread(&TrackedRun::cpu_over_orb), error = spread(&TrackedRun::live_mm),
                 after = spread(&TrackedRun::after_mm);
    if (i == 0) usual_cost = cost.median, usual_error = error.median;
    fmt::print(
        "{}, {}, {} levels: {:.2f} times cv::ORB, live {:.2f} mm ({:.2f} to {:.2f}), after {:.2f} mm ({:.2f} "
        "to {:.2f}), {:.1f} % of frames\n",
        situation.panel, situation.series, levels[i], cost.median, error.median, error.low, error.high,
        after.median, after.low, after.high, 100 * spread(&TrackedRun::tracked_share).median);
    table.Add(situation.panel, situation.series, std::to_string(levels[i]), cost.median / usual_cost,
              error.median / usual_error, levels[i] == TrackerOptions{}.corners.levels);
  }
}

Chart MeasureLevels(const Effort& effort) {
  Table table;
  for (const Situation& situation : Situations(effort)) {
    table.Panel(situation.panel, {"CPU of a frame / eight levels"}, Log("error / eight levels"),
                {.compared = false});
    AddLevels(situation, effort, table);
  }
  return {.panels = table.panels()};
}

CHART(tracking_levels, MeasureLevels,
      "Pyramid levels that corners are detected on: error and cost over those of eight levels", R"(Names are
  levels. Simulator: three seeds, 15 frames a second, row_deg=4. Recordings: 300 frames with 10 features
  more and fewer, or every tenth of all, begun at three of the ten frames. Errors of live centres, RMS after
  alignment, medians of three runs; CPU of the tracking thread, mapping apart. Frames without a pose are
  written to the terminal.)");

}  // namespace
}  // namespace ulf::test
