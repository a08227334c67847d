// Tracking: how many keyframes a local adjustment moves, and from how many on the whole map is solved by
// conjugate gradients, against the error of live poses.
#include "tests/charts/makers.h"
#include "tests/charts/tracking/tracking_runs.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct Choice {
  std::string series, name;
  MapperOptions options;
};

std::vector<Choice> Choices(const ChartEffort& effort) {
  std::vector<Choice> choices;
  for (const int keyframes : effort.Of(std::vector{7}, {5, 7, 14, 20})) {
    choices.push_back({"keyframes of a local adjustment", std::to_string(keyframes), {}});
    choices.back().options.local_keyframes = keyframes;
  }
  for (const int cameras : effort.Of(std::vector{30}, {30, 120})) {
    choices.push_back({"solved dense up to so many", std::to_string(cameras), {}});
    choices.back().options.dense_cameras = cameras;
  }
  return choices;
}

constexpr int kRuns = 3;

}  // namespace

Chart TrackingAdjustmentChart(const ChartEffort& effort) {
  Chart chart;
  chart.title = "The map's adjustments: what they cost against the error of live poses";
  chart.about =
      "Cost: processor time of everything but the tracking of a frame, by the number of frames, over cv::ORB "
      "with "
      "1,000 features. Simulator: seeds 91 to 93, 360 frames, 15 a second, room. Recordings: the whole, "
      "with 10 "
      "features more and fewer. Medians of three runs, bars: lowest to highest.";
  const int each = effort.Of(1, kRuns);
  for (const std::string& recording :
       effort.Of(std::vector<std::string>{"sim:room?row_deg=4"},
                 {"handheld_kitchen", "scan_synthetic", "sim:room?row_deg=4"})) {
    if (!HasRecording(recording)) continue;
    const std::vector<Choice> choices = Choices(effort);
    std::vector<TrackedCase> cases;
    for (const Choice& choice : choices)
      for (int run = 0; run < each; ++run) {
        TrackedCase one{
            recording, {.deterministic = true}, effort.Of(60, IsSimulated(recording) ? 360 : 100000)};
        one.options.mapping = choice.options;
        if (IsSimulated(recording))
          one.options.seed = 91 + static_cast<unsigned>(run);
        else
          one.options.features += run == 0 ? 0 : run == 1 ? -10 : 10;
        cases.push_back(one);
      }
    const std::vector<TrackedRun> runs = TrackRuns(cases);
    ChartPanel panel{NameOf(recording),
                     {"mapping a frame [times cv::ORB with 1,000 features, CPU]"},
                     {"centres, live, RMS [mm]", true},
                     {}};
    auto run = runs.begin();
    for (const Choice& choice : choices) {
      std::vector<double> cost, error, after;
      for (int i = 0; i < each; ++i, ++run) {
        cost.push_back(run->mapping_over_orb);
        error.push_back(run->live_mm);
        after.push_back(run->after_mm);
      }
      fmt::print("{}, {} {}: {:.2f} times cv::ORB, live {:.2f} mm ({:.2f} to {:.2f}), after {:.2f} mm\n",
                 recording, choice.series, choice.name, Spread::Of(cost).median, Spread::Of(error).median,
                 Spread::Of(error).low, Spread::Of(error).high, Spread::Of(after).median);
      std::fflush(stdout);
      panel.points.push_back({choice.series, choice.name, Spread::Of(cost), Spread::Of(error),
                              choice.options.local_keyframes == MapperOptions{}.local_keyframes &&
                                  choice.options.dense_cameras == MapperOptions{}.dense_cameras});
    }
    chart.panels.push_back(panel);
  }
  return chart;
}

}  // namespace ulf::test
