// Tracking: how many keyframes a local adjustment moves, and from how many on the whole map is solved by
// conjugate gradients, against the error of live poses.
#include "tests/charts/tracking/tracking_runs.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct Choice {
  std::string series, name;
  MapperOptions options;
  bool IsDefault() const {
    return options.local_keyframes == MapperOptions{}.local_keyframes &&
           options.dense_cameras == MapperOptions{}.dense_cameras;
  }
};

std::vector<Choice> Choices(const Effort& effort) {
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

Chart MeasureAdjustment(const Effort& effort) {
  Table table;
  for (const std::string& recording :
       effort.Of(std::vector<std::string>{"sim:room?row_deg=4"},
                 {"handheld_kitchen", "scan_synthetic", "sim:room?row_deg=4"})) {
    if (!HasRecording(recording)) continue;
    std::vector<TrackedCase> cases;
    for (const bool live : {true, false})
      table.Panel(NameOf(recording) + (live ? "" : ", after the run"),
                  {"mapping a frame [times cv::ORB with 1,000 features, CPU]"},
                  Log(live ? "centres, live, RMS [mm]" : "centres, RMS [mm]"));
    for (const Choice& choice : Choices(effort)) {
      TrackedCase one{recording, {.deterministic = true}, effort.Of(60, IsSimulated(recording) ? 360 : 300)};
      one.options.mapping = choice.options;
      one.panel = NameOf(recording);
      one.series = choice.series;
      one.name = choice.name;
      one.is_default = choice.IsDefault();
      for (const TrackedCase& run : Repeated(one, effort)) cases.push_back(run);
    }
    const std::vector<TrackedRun> runs = TrackRuns(cases);
    AddRuns(cases, runs, &TrackedRun::mapping_over_orb, &TrackedRun::live_mm, table);
    for (TrackedCase& one : cases) one.panel += ", after the run";
    AddRuns(cases, runs, &TrackedRun::mapping_over_orb, &TrackedRun::after_mm, table);
  }
  return {.panels = table.panels()};
}

CHART(tracking_adjustment, MeasureAdjustment,
      "The map's adjustments: what they cost against the error of live poses", R"(Cost: processor time of
  everything but the tracking of a frame, by the number of frames, over cv::ORB with 1,000 features.
  Simulator: three seeds, 360 frames, 15 a second, room. Recordings: 300 frames, with 10 features more and
  fewer. Medians of three runs, bars: lowest to highest.)");

}  // namespace
}  // namespace ulf::test
