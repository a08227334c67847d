// Tests: tracking/map/loop_closer, tracking/tracker/tracker_parts.
// Real film, cut, spliced, walked again and mirrored: what is joined or closed is right, the rest is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/device/device.h"
#include "acquisition/opening/open_device.h"
#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test::spliced_film_long_test {
namespace {

using namespace tracking;

// Frames `from` to `to`, forwards or backwards; mirrored, they show another place that looks much
// like this one.
struct Cut {
  int from, to;
  bool mirrored = false;
};

struct Film {
  CameraModel camera;
  std::vector<Frame> frames;
  std::vector<TimedPose> truth;

  explicit Film(const std::filesystem::path& folder)
      : camera(ReadCalibration(folder / "intrinsics.txt")), truth(ReadTum(folder / "colmap_reference.txt")) {
    const auto device = OpenDevice("replay:" + folder.string() + "?glob=*.color.jpg");
    device->Start();
    while (!IsOver(device->State()))
      if (auto frame = device->Next(std::chrono::milliseconds(1000))) frames.push_back(std::move(*frame));
  }
};

struct SplicedRun {
  TrackerStatistics map;
  int frames = 0, with_pose = 0;
  std::optional<TrajectoryError>
      error;  // after the run, of frames that are not mirrored and whose poses were sure
};

// The rows of film that runs backwards are read from the last to the first: no one readout is right for a
// splice that runs both ways.
SplicedRun Follow(const Film& film, const std::vector<Cut>& cuts,
                  const ReadoutArgs& readout = {.readout_s = 0}) {
  Tracker tracker(film.camera, {.deterministic = true, .readout = readout});
  SplicedRun run;
  std::vector<std::pair<Track, double>> tracks;  // and the time in the film; below 0: mirrored
  const auto step = [&](int k, bool mirrored) {
    Frame frame = film.frames[static_cast<std::size_t>(k)];
    const double in_film_s = frame.device_time_s;
    frame.device_time_s = run.frames++ / 30.0;
    if (mirrored) {
      cv::Mat flipped;
      cv::flip(frame.image.pixels, flipped, 1);
      frame.image.pixels = flipped;
    }
    tracks.emplace_back(tracker.Step(frame), mirrored ? -1 : in_film_s);
  };
  for (const Cut& cut : cuts)
    for (int k = cut.from; k != cut.to; k += cut.from < cut.to ? 1 : -1) step(k, cut.mirrored);
  tracker.Finish();
  run.map = tracker.Statistics();
  const auto last = std::find_if(tracks.rbegin(), tracks.rend(),
                                 [](const auto& one) { return one.first.cam_from_world.has_value(); });
  if (last == tracks.rend()) return run;
  // A place that was passed twice has two poses of one time in the film: the truth is given anew
  // for every frame.
  std::vector<TimedPose> poses, truth;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const auto& [track, in_film_s] = tracks[i];
    const auto pose = tracker.PoseNow(track);
    if (!pose || tracker.MapNow(track) != tracker.MapNow(last->first)) continue;
    ++run.with_pose;
    const double now_s = static_cast<double>(i) / 30;
    if (track.quality < 0.5) continue;  // it says that it may be wrong
    for (const TimedPose& known : film.truth)
      if (in_film_s >= 0 && std::abs(known.time_s - in_film_s) < 1.0 / 60) {
        poses.push_back({now_s, *pose});
        truth.push_back({now_s, known.cam_from_world});
      }
  }
  run.error = CompareTrajectories(poses, truth, 0.001);
  std::printf("%d frames, %d with a pose, %d parts, %d joined, %d loops, RMS %.1f mm, largest %.1f mm\n",
              run.frames, run.with_pose, run.map.parts, run.map.parts_joined, run.map.loops,
              run.error ? 1000 * run.error->ate_rmse : NAN, run.error ? 1000 * run.error->ate_max : NAN);
  return run;
}

TEST(SplicedFilm, JoinsAndLoopsAreRight) {
  ULF_NEED_TEST_DATA(folder, "handheld_kitchen");
  const Film film(folder);
  struct Splice {
    std::vector<Cut> cuts;
    int least_joined = 0;
  };
  const std::vector<Splice> splices = {
      {{{0, 150}, {450, 600}}, 1},
      {{{0, 150}, {450, 600}, {599, 100}}, 1},
      {{{450, 600}, {0, 450}}},
      {{{599, 450}, {150, -1}}},
      {{{0, 100}, {200, 300}, {400, 500}, {499, 0}}},
      {{{0, 300}, {299, 0}, {0, 300}}},             // there, back and there again
      {{{0, 100}, {599, 300}, {0, 100}}},           // from one end to the other, and home
      {{{0, 600}, {300, 0}, {599, 300}, {0, 60}}},  // all of it, then parts in another order
      {{{0, 600}, {0, 90}}}                         // all of it, and the beginning again
  };
  for (const auto& [cuts, least_joined] : splices) {
    const bool is_forwards = std::ranges::all_of(cuts, [](const Cut& cut) { return cut.from < cut.to; });
    const SplicedRun run = is_forwards ? Follow(film, cuts, {}) : Follow(film, cuts);
    EXPECT_GE(run.map.parts_joined, least_joined);
    ASSERT_TRUE(run.error);
    EXPECT_LT(run.error->ate_rmse, 0.02);
    EXPECT_LT(run.error->ate_max, 0.06) << "3 % of the distance";
    EXPECT_GT(run.with_pose, 0.7 * run.frames);
  }
}

TEST(SplicedFilm, BackwardsTheShutterRollsTheOtherWay) {
  ULF_NEED_TEST_DATA(folder, "handheld_kitchen");
  const Film film(folder);
  const SplicedRun forwards = Follow(film, {{0, 600}}, {}), backwards = Follow(film, {{599, -1}}, {});
  ASSERT_TRUE(forwards.map.rolling_shutter);
  ASSERT_TRUE(backwards.map.rolling_shutter);
  EXPECT_GT(forwards.map.rolling_shutter->readout_s, 0.02);
  EXPECT_NEAR(backwards.map.rolling_shutter->readout_s, -forwards.map.rolling_shutter->readout_s, 0.005);
}

// In a mirror the kitchen is another room whose things look much alike.
TEST(SplicedFilm, AMirroredPlaceIsNotJoined) {
  ULF_NEED_TEST_DATA(folder, "handheld_kitchen");
  const Film film(folder);
  for (const std::vector<Cut>& cuts : {std::vector<Cut>{{0, 200}, {0, 200, true}},
                                       {{0, 200}, {0, 200, true}, {200, 400}},
                                       {{0, 200}, {599, 300, true}, {199, 0}}}) {
    const SplicedRun run = Follow(film, cuts);
    EXPECT_EQ(run.map.parts_joined, 0);
    EXPECT_EQ(run.map.loops, 0);
    ASSERT_TRUE(run.error);
    EXPECT_LT(run.error->ate_max, 0.06);
  }
}

}  // namespace
}  // namespace ulf::test::spliced_film_long_test
