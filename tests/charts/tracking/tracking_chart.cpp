// Tracking: features, keyframes and size of the map against the error of the poses.
#include <map>

#include "tests/charts/makers.h"
#include "tests/charts/tracking/tracking_runs.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/predicted_error.h"

namespace ulf::test {
namespace {

const TrackerOptions kUsual{.deterministic = true};

// A choice of features and how far a keyframe is from the next; every one against every other
// where that is affordable, else one at a time.
struct Variation {
  std::string panel, series, name;
  TrackerOptions options;
  bool IsUsual() const {
    return options.features == kUsual.features &&
           options.mapping.keyframe_moved == kUsual.mapping.keyframe_moved;
  }
};

std::vector<Variation> Grid(const ChartEffort& effort) {
  std::vector<Variation> grid;
  for (const double moved : effort.Of(std::vector{0.03}, {0.015, 0.03, 0.08}))
    for (const int features : effort.Of(std::vector{500, 850}, {300, 500, 850, 1250})) {
      Variation variation{"simulator", fmt::format("a keyframe each {:g} % of the depth", 100 * moved),
                          std::to_string(features), kUsual};
      variation.options.features = features;
      variation.options.mapping.keyframe_moved = moved;
      grid.push_back(variation);
    }
  return grid;
}

std::vector<Variation> OneAtATime(const std::string& recording, const ChartEffort& effort) {
  std::vector<Variation> variations;
  const auto add = [&](const char* series, const std::string& name, auto&& change) {
    variations.push_back({recording, series, name, kUsual});
    change(variations.back().options);
  };
  for (const int features : effort.Of(std::vector{500, 850}, {300, 500, 850, 1250}))
    add("features", std::to_string(features), [&](TrackerOptions& options) { options.features = features; });
  for (const double moved : effort.Of(std::vector<double>{}, {0.015, 0.08}))
    add("keyframes", fmt::format("each {:g} %", 100 * moved),
        [&](TrackerOptions& options) { options.mapping.keyframe_moved = moved; });
  return variations;
}

struct Threshold {
  std::string name;
  double MapperOptions::*value;
  std::vector<double> tried, tried_quickly;
};

std::vector<Threshold> Thresholds() {
  return {{"keyframe moved", &MapperOptions::keyframe_moved, {0.015, 0.05, 0.12}, {0.08}},
          {"superfluous share", &MapperOptions::superfluous_share, {0.6, 0.8, 1.01}, {0.6}},
          {"least found share", &MapperOptions::min_found_share, {0, 0.6}, {0.6}},
          {"least parallax", &MapperOptions::min_parallax_deg, {0.5, 3}, {3}}};
}

// The runs of a variation: the seeds of the simulator, and of a recording, where a seed hardly changes
// anything, ten features more and fewer.
constexpr int kRuns = 3;
TrackedCase CaseOf(const Variation& variation, const std::string& recording, int run, int frames) {
  TrackedCase one{recording, variation.options, frames};
  if (IsSimulated(recording))
    one.options.seed = 51 + static_cast<unsigned>(run);
  else
    one.options.features += run == 0 ? 0 : run == 1 ? -10 : 10;
  return one;
}

// A panel for each that the variations name.
std::vector<ChartPanel> TrackVariations(const std::vector<Variation>& variations,
                                        const std::string& recording, int frames, const ChartEffort& effort) {
  const int each = effort.Of(1, kRuns);
  std::vector<TrackedCase> cases;
  for (const Variation& variation : variations)
    for (int run = 0; run < each; ++run) cases.push_back(CaseOf(variation, recording, run, frames));
  const std::vector<TrackedRun> runs = TrackRuns(cases);
  std::vector<ChartPanel> panels;
  auto run = runs.begin();
  for (const Variation& variation : variations) {
    if (panels.empty() || panels.back().title != variation.panel)
      panels.push_back({variation.panel,
                        {"a frame [times cv::ORB with 1,000 features, CPU]"},
                        {"centres, live, RMS [mm]", true},
                        {}});
    std::vector<double> cost, error;
    for (int i = 0; i < each; ++i, ++run) {
      cost.push_back(run->cpu_over_orb);
      error.push_back(run->live_mm);
    }
    panels.back().points.push_back(
        {variation.series, variation.name, Spread::Of(cost), Spread::Of(error), variation.IsUsual()});
  }
  return panels;
}

}  // namespace

Chart TrackingChart(const ChartEffort& effort) {
  Chart chart;
  chart.title = "Tracking: features and keyframes against the error of live poses";
  chart.about =
      "Simulator: studio, row_deg=4, seeds 51 to 53, 150 frames, every choice with every other; names are "
      "features. handheld_kitchen: all of it, the default changed in one respect at a time, with 10 features "
      "more and fewer (it was tuned on, the simulator's seeds were not). CPU of the tracking thread, mapping "
      "apart, over cv::ORB with 1,000 features in the same run. Bars: lowest to highest.";
  chart.panels = TrackVariations(Grid(effort), kStudio, effort.Of(60, 150), effort);
  if (const std::string kitchen = "handheld_kitchen"; HasRecording(kitchen))
    for (const ChartPanel& panel :
         TrackVariations(OneAtATime(kitchen, effort), kitchen, effort.Of(120, 100000), effort))
      chart.panels.push_back(panel);
  return chart;
}

Chart MapSizeChart(const ChartEffort& effort) {
  Chart chart;
  chart.title = "The map: what keyframes and points bring, one threshold varied at a time";
  chart.about =
      "Whole runs of two recordings that the thresholds were tuned on, 850 features, one run each: on the "
      "kitchen differences of a fifth say nothing. Names: the threshold's value.";
  for (const std::string recording : {"handheld_kitchen", "scan_synthetic"}) {
    if (!HasRecording(recording)) continue;
    std::vector<TrackedCase> cases{{recording, {.deterministic = true}, effort.Of(60, 100000)}};
    std::vector<ChartRow> points{{"as in use", "", {}, {}, true}};
    for (const Threshold& threshold : Thresholds())
      for (const double value : effort.Of(threshold.tried_quickly, threshold.tried)) {
        if (value == MapperOptions{}.*threshold.value) continue;
        cases.push_back(cases.front());
        cases.back().options.mapping.*threshold.value = value;
        points.push_back({threshold.name, fmt::format("{:g}", value), {}, {}});
      }
    const std::vector<TrackedRun> runs = TrackRuns(cases);
    for (const bool by_points : {true, false}) {
      ChartPanel panel{recording + (by_points ? ": points" : ": keyframes"),
                       {by_points ? "map points" : "keyframes"},
                       {"centres, after the run, RMS [mm]", true},
                       points};
      for (std::size_t i = 0; i < runs.size(); ++i) {
        panel.points[i].cost = Spread::Exactly(by_points ? runs[i].points : runs[i].keyframes);
        panel.points[i].error = Spread::Exactly(runs[i].after_mm);
      }
      chart.panels.push_back(panel);
    }
  }
  return chart;
}

Chart PredictedErrorChart(const ChartEffort& effort) {
  std::vector<std::pair<std::string, std::vector<ErrorBin>>> runs;  // of each series one or several
  const auto add = [&](const std::string& series, const std::vector<PredictedError>& errors) {
    runs.emplace_back(series, BinErrors(errors, 4));
  };
  for (const unsigned seed : effort.Of(std::vector{1u}, {1u, 2u}))
    for (const double noise : effort.Of(std::vector{4.0}, {1.0, 4.0, 12.0}))
      for (const int features : effort.Of(std::vector{300}, {300, 1000}))
        add("drawn room, noise 1 to 12, 300 and 1,000 features",
            RoomErrors(noise, features, seed, effort.Of(60, 150)));
  for (const unsigned seed : effort.Of(std::vector<unsigned>{}, {1u, 2u}))
    add("simulated studio, two seeds", SimulatorErrors("studio", seed, 10));
  for (const std::string& scene :
       effort.Of(std::vector<std::string>{}, {"gloss", "glass", "plant", "bust", "branch"}))
    add("five hard simulated scenes", SimulatorErrors(scene, 3, 10));
  for (const unsigned seed : effort.Of(std::vector<unsigned>{}, {1u, 2u, 3u}))
    add("turns on the spot, rolling shutter", TurnErrors(seed, 300));
  for (const std::string& recording :
       effort.Of(std::vector<std::string>{}, {"scan_synthetic", "handheld_kitchen"}))
    if (const auto folder = TestData(recording)) add(recording, RecordingErrors(*folder));
  const auto rises = [](const auto& run) {
    return std::ranges::is_sorted(run.second, {}, &ErrorBin::actual);
  };
  const auto ends_right = [](const auto& run) {
    return run.second.front().actual < run.second.back().actual;
  };
  Chart chart;
  chart.title = "What the tracker predicts about its error, against the error";
  chart.about = fmt::format(
      "Every pose as it was given live, errors after one alignment of a whole run; quarters of each run by "
      "what was "
      "predicted, medians. Right is the diagonal. The prediction was made on simulated scenes and drawn "
      "rooms. True errors "
      "rise from quarter to quarter in {} of {} runs; the surest quarter is more exact than the least sure "
      "in {}.",
      std::ranges::count_if(runs, rises), runs.size(), std::ranges::count_if(runs, ends_right));
  ChartPanel panel{"the camera's centre",
                   {"predicted [% of the distance]", true},
                   {"true [% of the distance]", true},
                   {},
                   false};
  panel.diagonal = true;
  panel.joined = false;  // the quarters of one run belong together, not those of all
  for (const auto& [series, bins] : runs)
    for (const ErrorBin& bin : bins)
      panel.points.push_back(
          {series, "", Spread::Exactly(100 * bin.predicted), Spread::Exactly(100 * bin.actual)});
  chart.panels.push_back(panel);
  return chart;
}

}  // namespace ulf::test
