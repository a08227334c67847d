// Tracking: pyramid levels that corners are detected on, where the camera goes nearer and farther, where it
// does not, in pictures that are soft or noisy, and with few frames a second.
#include "core/base/quantile.h"
#include "tests/charts/makers.h"
#include "tests/charts/tracking/tracking_runs.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct Situation {
  std::string panel, series;
  TrackedCase tracked;
};

std::vector<Situation> Situations(const ChartEffort& effort) {
  std::vector<Situation> situations;
  const auto add = [&](const char* panel, const char* series, const char* recording, int frames,
                       auto&& change) {
    if (!HasRecording(recording)) return;
    situations.push_back({panel, series, {recording, {.deterministic = true}, effort.Of(60, frames)}});
    change(situations.back().tracked);
  };
  const auto as_it_is = [](TrackedCase&) {};
  const char* const few = "every 10th frame";
  const auto sparse = [](TrackedCase& one) { one.every = 10; };
  add(few, "studio, 0.5 to 2 times as far", "sim:studio?dolly=2&row_deg=4", 360, sparse);
  if (effort.quick) return situations;
  add(few, "kitchen", "handheld_kitchen", 100000, sparse);
  add(few, "scan", "scan_synthetic", 100000, sparse);
  const char* const soft = "soft and noisy";
  const auto blurred = [](TrackedCase& one) { one.change.blur_px = 2; };
  const auto noisy = [](TrackedCase& one) { one.change.noise = 15; };
  add(soft, "kitchen, blurred by 2 px", "handheld_kitchen", 100000, blurred);
  add(soft, "kitchen, noise of 15 levels", "handheld_kitchen", 100000, noisy);
  const char* const alike = "always about as far away";
  add(alike, "studio", kStudio, 200, as_it_is);
  add(alike, "handheld_kitchen", "handheld_kitchen", 100000, as_it_is);
  add(alike, "scan_synthetic", "scan_synthetic", 100000, as_it_is);
  const char* const near_and_far = "nearer and farther";
  add(near_and_far, "studio, 0.5 to 2 times as far", "sim:studio?dolly=2&row_deg=4", 360, as_it_is);
  add(near_and_far, "bust, 0.33 to 3 times", "sim:bust?dolly=3&row_deg=4", 360, as_it_is);
  return situations;
}

// The simulator's seeds; of a recording, where a seed hardly changes anything, ten features more and fewer;
// of every 10th frame, the first.
constexpr int kRuns = 3;
void MakeRun(TrackedCase& one, int run) {
  one.first = StartOf(run, one.every);
  if (IsSimulated(one.recording))
    one.options.seed = 61 + static_cast<unsigned>(run);
  else if (one.every == 1)
    one.options.features += run == 0 ? 0 : run == 1 ? -10 : 10;
}

}  // namespace

Chart TrackingLevelsChart(const ChartEffort& effort) {
  const std::vector<int> levels = effort.Of(std::vector{8, 3}, {8, 5, 4, 3, 2});
  const int each = effort.Of(1, kRuns);
  const std::vector<Situation> situations = Situations(effort);
  Chart chart;
  chart.title = "Pyramid levels that corners are detected on: error and cost over those of eight levels";
  chart.about =
      "Names are levels. Simulator: seeds 61 to 63, 15 frames a second, row_deg=4. Recordings: the whole, "
      "with 10 "
      "features more and fewer, or begun at three of the ten frames. Errors of live centres, RMS after "
      "alignment, "
      "medians of three runs; CPU of the tracking thread, mapping apart. Frames without a pose are written "
      "to the "
      "terminal. No number of levels was chosen on the simulator's seeds.";
  for (const Situation& situation : situations) {
    std::vector<TrackedCase> cases;
    for (const int count : levels)
      for (int run = 0; run < each; ++run) {
        cases.push_back(situation.tracked);
        cases.back().options.corners.levels = count;
        MakeRun(cases.back(), run);
      }
    const std::vector<TrackedRun> runs = TrackRuns(cases);
    if (chart.panels.empty() || chart.panels.back().title != situation.panel)
      chart.panels.push_back(
          {situation.panel, {"CPU of a frame / eight levels"}, {"error / eight levels", true}, {}, false});
    double usual_cost = 1, usual_error = 1;
    for (std::size_t i = 0; i < levels.size(); ++i) {
      std::vector<double> cost, error, after, share;
      for (std::size_t run = 0; run < At(each); ++run) {
        const TrackedRun& one = runs[i * At(each) + run];
        cost.push_back(one.cpu_over_orb);
        error.push_back(one.live_mm);
        after.push_back(one.after_mm);
        share.push_back(one.tracked_share);
      }
      if (i == 0) usual_cost = Median(cost), usual_error = Median(error);
      fmt::print(
          "{}, {}, {} levels: {:.2f} times cv::ORB, live {:.2f} mm ({:.2f} to {:.2f}), after {:.2f} mm "
          "({:.2f} to {:.2f}), {:.1f} % of frames\n",
          situation.panel, situation.series, levels[i], Median(cost), Median(error), Spread::Of(error).low,
          Spread::Of(error).high, Median(after), Spread::Of(after).low, Spread::Of(after).high,
          100 * Median(share));
      std::fflush(stdout);
      chart.panels.back().points.push_back(
          {situation.series, std::to_string(levels[i]), Spread::Exactly(Median(cost) / usual_cost),
           Spread::Exactly(Median(error) / usual_error), levels[i] == TrackerOptions{}.corners.levels});
    }
  }
  return chart;
}

}  // namespace ulf::test
