// Real sequences through the tracker, as the command does it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/opening/open_device.h"
#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test {

struct DataRun {
  int frames = 0, first_tracked = -1, tracked = 0, lost = 0;
  std::vector<int> relocalized;
  TrajectoryError live, final;
};

// Frames 0..last-1 without skip_from..skip_to-1; times as in the whole sequence.
inline DataRun TrackData(const std::filesystem::path& folder, const std::string& glob,
                         const std::string& truth, int last, unsigned seed, int skip_from = 0,
                         int skip_to = 0) {
  const auto device = OpenDevice("replay:" + folder.string() + "?glob=" + glob);
  device->Start();
  Tracker tracker(ReadCalibration(folder / "intrinsics.txt"), {.deterministic = true, .seed = seed});
  DataRun run;
  std::vector<TimedPose> live, final;
  std::vector<std::pair<double, Anchored>> anchors;
  TrackState before = TrackState::kInitializing;
  for (int k = 0; k < last; ++k) {
    const auto frame = device->Next(std::chrono::milliseconds(1000));
    if (!frame) break;
    if (k >= skip_from && k < skip_to) continue;
    ++run.frames;
    const Track track = tracker.Step(*frame);
    if (before == TrackState::kTracking && track.state != before) ++run.lost;
    if (track.relocalized) run.relocalized.push_back(k);
    before = track.state;
    if (!track.cam_from_world) continue;
    if (run.first_tracked < 0) run.first_tracked = k;
    ++run.tracked;
    live.push_back({frame->device_time_s, *track.cam_from_world});
    anchors.emplace_back(frame->device_time_s, *track.anchor);
  }
  tracker.Finish();
  for (const auto& [time_s, anchor] : anchors) final.push_back({time_s, tracker.PoseOf(anchor)});
  const auto reference = ReadTum(folder / truth);
  TrajectoryError hopeless;
  hopeless.ate_rmse = hopeless.ate_max = 1e9;
  run.live = CompareTrajectories(live, reference, 1.0 / 60).value_or(hopeless);
  run.final = CompareTrajectories(final, reference, 1.0 / 60).value_or(hopeless);
  return run;
}

}  // namespace ulf::test
