// Tracking: features, keyframes and size of the map against the error of the poses.
#include <algorithm>

#include "tests/charts/tracking/tracking_runs.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/predicted_error.h"

namespace ulf::test {
namespace {

constexpr char kCost[] = "a frame [times cv::ORB with 1,000 features, CPU]";
constexpr char kLive[] = "centres, live, RMS [mm]";

struct Variation {
  std::string series, name;
  int features = TrackerOptions{}.features;
  double keyframe_moved = MapperOptions{}.keyframe_moved;
};

// Every choice with every other, where that is affordable.
std::vector<Variation> Grid(const Effort& effort) {
  std::vector<Variation> grid;
  for (const double moved : effort.Of(std::vector{0.03}, {0.015, 0.03, 0.08}))
    for (const int features : effort.Of(std::vector{500, 850}, {300, 500, 850, 1250}))
      grid.push_back({fmt::format("a keyframe each {:g} % of the depth", 100 * moved),
                      std::to_string(features), features, moved});
  return grid;
}

std::vector<Variation> OneAtATime(const Effort& effort) {
  std::vector<Variation> variations;
  for (const int features : effort.Of(std::vector{500, 850}, {300, 500, 850, 1250}))
    variations.push_back({.series = "features", .name = std::to_string(features), .features = features});
  for (const double moved : effort.Of(std::vector<double>{}, {0.015, 0.08}))
    variations.push_back(
        {.series = "keyframes", .name = fmt::format("each {:g} %", 100 * moved), .keyframe_moved = moved});
  return variations;
}

void AddVariations(const std::vector<Variation>& variations, const std::string& recording, int frames,
                   const Effort& effort, Table& table) {
  table.Panel(NameOf(recording), {kCost}, Log(kLive));
  std::vector<TrackedCase> cases;
  for (const Variation& variation : variations) {
    TrackedCase one{recording, {.deterministic = true, .features = variation.features}, frames};
    one.options.mapping.keyframe_moved = variation.keyframe_moved;
    one.panel = NameOf(recording);
    one.series = variation.series;
    one.name = variation.name;
    one.is_default = variation.features == TrackerOptions{}.features &&
                     variation.keyframe_moved == MapperOptions{}.keyframe_moved;
    for (const TrackedCase& run : Repeated(one, effort)) cases.push_back(run);
  }
  AddRuns(cases, TrackRuns(cases), &TrackedRun::cpu_over_orb, &TrackedRun::live_mm, table);
}

Chart MeasureTracking(const Effort& effort) {
  Table table;
  AddVariations(Grid(effort), kStudio, effort.Of(60, 150), effort, table);
  if (HasRecording("handheld_kitchen"))
    AddVariations(OneAtATime(effort), "handheld_kitchen", effort.Of(120, 300), effort, table);
  return {.panels = table.panels()};
}

CHART(tracking, MeasureTracking, "Tracking: features and keyframes against the error of live poses",
      R"(Simulator: studio, row_deg=4, three seeds, 150 frames, every choice with every other; names are
  features. handheld_kitchen, which was tuned on: 300 frames, the default changed in one respect at a time,
  with 10 features more and fewer. CPU of the tracking thread, mapping apart, over cv::ORB with 1,000
  features in the same run. Bars: lowest to highest.)");

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

Chart MeasureMapSize(const Effort& effort) {
  Table table;
  for (const std::string recording : {"handheld_kitchen", "scan_synthetic"}) {
    if (!HasRecording(recording)) continue;
    TrackedCase usual{recording, {.deterministic = true}, effort.Of(60, 100000)};
    usual.series = usual.name = "as in use";
    usual.is_default = true;
    std::vector<TrackedCase> cases{usual};
    for (const Threshold& threshold : Thresholds())
      for (const double value : effort.Of(threshold.tried_quickly, threshold.tried)) {
        if (value == MapperOptions{}.*threshold.value) continue;
        TrackedCase one{recording, {.deterministic = true}, usual.frames};
        one.options.mapping.*threshold.value = value;
        one.series = threshold.name;
        one.name = fmt::format("{:g}", value);
        cases.push_back(one);
      }
    const std::vector<TrackedRun> runs = TrackRuns(cases);
    for (const bool by_points : {true, false}) {
      const std::string title = recording + (by_points ? ": points" : ": keyframes");
      table.Panel(title, {by_points ? "map points" : "keyframes"}, Log("centres, after the run, RMS [mm]"));
      for (TrackedCase& one : cases) one.panel = title;
      AddRuns(cases, runs, by_points ? &TrackedRun::points : &TrackedRun::keyframes, &TrackedRun::after_mm,
              table);
    }
  }
  return {.panels = table.panels()};
}

CHART(map_size, MeasureMapSize, "The map: what keyframes and points bring, one threshold varied at a time",
      R"(Whole runs of two recordings that the thresholds were tuned on, one run each: on the kitchen
  differences of a fifth say nothing. Names: the threshold's value.)");

Chart MeasurePredictedErrors(const Effort& effort) {
  std::vector<std::pair<std::string, std::vector<ErrorBin>>> runs;  // of each series one or several
  const auto add = [&](const std::string& series, const std::vector<PredictedError>& errors) {
    runs.emplace_back(series, BinErrors(errors, 4));
  };
  for (const unsigned seed : effort.Seeds(2))
    for (const double noise : effort.Of(std::vector{4.0}, {1.0, 4.0, 12.0}))
      for (const int features : effort.Of(std::vector{300}, {300, 1000}))
        add("drawn room, noise 1 to 12, 300 and 1,000 features",
            RoomErrors(noise, features, seed, effort.Of(60, 150)));
  for (const unsigned seed : effort.quick ? std::vector<unsigned>{} : effort.Seeds(2))
    add("simulated studio, two seeds", SimulatorErrors("studio", seed, 10));
  for (const std::string& scene :
       effort.Of(std::vector<std::string>{}, {"gloss", "glass", "plant", "bust", "branch"}))
    add("five hard simulated scenes", SimulatorErrors(scene, kFirstSeed, 10));
  for (const unsigned seed : effort.quick ? std::vector<unsigned>{} : effort.Seeds(3))
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
  const std::string panel = "the camera's centre";
  Table table;
  // The quarters of one run belong together, not those of all.
  table.Panel(panel, Log("predicted [% of the distance]"), Log("true [% of the distance]"),
              {.compared = false, .joined = false, .diagonal = true});
  for (const auto& [series, bins] : runs)
    for (const ErrorBin& bin : bins) table.Add(panel, series, "", 100 * bin.predicted, 100 * bin.actual);
  return {.found = fmt::format(
              "True errors rise from quarter to quarter in {} of {} runs; the surest quarter is more "
              "exact than the least sure in {}.",
              std::ranges::count_if(runs, rises), runs.size(), std::ranges::count_if(runs, ends_right)),
          .panels = table.panels()};
}

CHART(predicted_error, MeasurePredictedErrors, "What the tracker predicts about its error, against the error",
      R"(Every pose as it was given live, errors after one alignment of a whole run; quarters of each run by
  what was predicted, medians. Right is the diagonal. The prediction was made on simulated scenes and drawn
  rooms.)");

}  // namespace
}  // namespace ulf::test
