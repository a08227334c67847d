// Tests: tracking/tracker/tracker, tracking/tracker/tracker_keyframes, tracking/tracker/tracker_core,
// commands/tracking/track_command.
#include "tracking/tracker/tracker.h"
#include "core/base/json_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tests/tracking/scenes/predicted_error.h"
#include "tests/tracking/scenes/standing.h"
#include "tests/tracking/scenes/textured_room.h"

namespace ulf::tracker_test {
namespace {

using test::TexturedRoom;

struct Result {
  std::vector<Track> tracks;
  std::vector<TimedPose> live, final, truth;
  int first_tracked = -1;

  int Tracked() const { return static_cast<int>(live.size()); }
  double AteLive() const { return CompareTrajectories(live, truth, 0.001)->ate_rmse; }
  double AteFinal() const { return CompareTrajectories(final, truth, 0.001)->ate_rmse; }
};

// `make(k)` gives the frame; the tracker may be used on afterwards.
template <typename Make>
Result TrackFrames(Tracker& tracker, int first, int last, Make&& make) {
  Result result;
  for (int k = first; k < last; ++k) {
    const Frame frame = make(k);
    const Track track = tracker.Step(frame);
    if (frame.known_cam_from_world)
      result.truth.push_back({frame.device_time_s, *frame.known_cam_from_world});
    if (track.cam_from_world) {
      if (result.first_tracked < 0) result.first_tracked = k;
      result.live.push_back({frame.device_time_s, *track.cam_from_world});
    }
    result.tracks.push_back(track);
  }
  tracker.Finish();
  for (std::size_t i = 0; i < result.tracks.size(); ++i)
    if (result.tracks[i].anchor)
      result.final.push_back({result.truth[i].time_s, tracker.PoseOf(*result.tracks[i].anchor)});
  return result;
}

constexpr TrackerOptions kRepeatable{.deterministic = true};

// A quarter of the pixels, for what does not hang by how precise poses are: a third of the time.
const CameraModel kSmall = TexturedRoom::Camera().ScaledTo(320, 240);
constexpr TrackerOptions kSmallRepeatable{.deterministic = true, .features = 500};

TEST(TrackerTest, FollowsAHandThroughARoom) {
  for (const unsigned seed : test::SeedsOf({1, 2})) {
    const TexturedRoom room({.seed = seed});
    Tracker tracker(TexturedRoom::Camera(), {.deterministic = true, .seed = seed});
    const Result result =
        TrackFrames(tracker, 0, 120, [&](int k) { return room.Take(TexturedRoom::HandAt(k), k); });
    ASSERT_GE(result.first_tracked, 0) << "seed " << seed;
    EXPECT_LE(result.first_tracked, 25) << "seed " << seed;
    EXPECT_EQ(result.Tracked(), 120 - result.first_tracked) << "seed " << seed;
    EXPECT_LT(result.AteLive(), 0.005) << "seed " << seed;
    EXPECT_LT(result.AteFinal(), 0.003) << "seed " << seed;
    EXPECT_GT(tracker.Points().size(), 200u);
    EXPECT_GT(tracker.VisiblePoints().size(), 50u);
    for (const VisiblePoint& point : tracker.VisiblePoints()) EXPECT_GT(point.depth, 0);
    EXPECT_GE(tracker.Statistics().keyframes, 3);
    const Track& last = result.tracks.back();
    EXPECT_GT(last.quality, 0.5);
    EXPECT_GT(last.speed_px, 0);
    EXPECT_GT(last.matched_points, 50);
    ASSERT_TRUE(last.center_sigma);
    EXPECT_GT(*last.center_sigma, 0);
    EXPECT_LT(*last.center_sigma, 0.05);
  }
}

TEST(TrackerTest, TheMapStartsWithMedianDepthOne) {
  const TexturedRoom room({});
  Tracker tracker(TexturedRoom::Camera(), kRepeatable);
  for (int k = 0; k < 60; ++k)
    if (tracker.Step(room.Take(TexturedRoom::HandAt(k), k)).state == TrackState::kTracking) break;
  std::vector<double> depths;
  for (const VisiblePoint& point : tracker.VisiblePoints()) depths.push_back(point.depth);
  ASSERT_GT(depths.size(), 50u);
  std::nth_element(depths.begin(), depths.begin() + static_cast<long>(depths.size() / 2), depths.end());
  EXPECT_NEAR(depths[depths.size() / 2], 1, 0.15);
}

TEST(TrackerTest, TheStartTellsHowMuchParallaxIsMissing) {
  const TexturedRoom room({});
  Tracker tracker(TexturedRoom::Camera(), kRepeatable);
  std::vector<double> shares;
  for (int k = 0; k < 60; ++k) {
    const Track track = tracker.Step(room.Take(TexturedRoom::HandAt(k), k));
    ASSERT_TRUE(track.start) << k;
    if (track.state == TrackState::kTracking) {
      EXPECT_EQ(track.start->obstacle, StartObstacle::kNone);
      EXPECT_GE(track.start->parallax_deg, track.start->parallax_needed_deg);
      ASSERT_GE(shares.size(), 3u);
      EXPECT_LT(shares[1], 0.7);
      EXPECT_GT(shares.back(), shares[1]);
      EXPECT_FALSE(tracker.Step(room.Take(TexturedRoom::HandAt(k + 1), k + 1)).start);
      return;
    }
    EXPECT_NE(track.start->obstacle, StartObstacle::kNone) << k;
    EXPECT_TRUE(k == 0 || track.start->matches >= track.start->matches_needed) << k;
    shares.push_back(track.start->parallax_deg / track.start->parallax_needed_deg);
  }
  FAIL() << "never started";
}

// A hand that rests: no keyframes, no points, no drift. (A whole minute of it is in tracker_long_test.cpp.)
TEST(TrackerTest, AStandingCameraAddsNothingAndStays) { test::ExpectNothingAdded(test::StandStill(150)); }

// No more keyframes and points than what is seen needs: the same way to and fro wants few, a longer one more.
TEST(TrackerTest, AMapGrowsWithTheWayAndNotWithTime) {
  const TexturedRoom room({.seed = 6});
  const auto map_after = [&](int frames, auto&& along) {
    Tracker tracker(kSmall, kSmallRepeatable);
    const Result result = TrackFrames(
        tracker, 0, frames, [&](int k) { return room.Take(TexturedRoom::HandAt(along(k)), k, kSmall); });
    EXPECT_GE(result.first_tracked, 0);
    EXPECT_GT(result.Tracked(), frames - 45);
    return tracker.Statistics();
  };
  constexpr int kTurn = 40;
  const auto there = [](int k) { return k; };
  const auto to_and_fro = [](int k) { return k % (2 * kTurn) < kTurn ? k % kTurn : kTurn - k % kTurn; };
  const TrackerStatistics once = map_after(kTurn, there), again = map_after(3 * kTurn, to_and_fro),
                          on = map_after(3 * kTurn, there);
  EXPECT_LE(again.keyframes, once.keyframes + 3);
  EXPECT_LE(again.map_points, 1.6 * once.map_points);
  EXPECT_GE(on.keyframes, 1.3 * again.keyframes);
  EXPECT_GE(on.map_points, 1.2 * again.map_points);
}

TEST(TrackerTest, IsFoundAgainAfterDarkness) {
  const TexturedRoom room({});
  Tracker tracker(kSmall, kSmallRepeatable);
  const auto make = [&](int k) {
    Frame frame = room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), kSmall);
    if (k >= 60 && k < 75) frame.image.pixels.setTo(20);
    return frame;
  };
  const Result result = TrackFrames(tracker, 0, 110, make);
  for (int k = 60; k < 75; ++k) {
    EXPECT_EQ(result.tracks[static_cast<std::size_t>(k)].state, TrackState::kLost) << "frame " << k;
    EXPECT_FALSE(result.tracks[static_cast<std::size_t>(k)].cam_from_world);
  }
  int found = -1;
  for (int k = 75; k < 110 && found < 0; ++k)
    if (result.tracks[static_cast<std::size_t>(k)].relocalized) found = k;
  ASSERT_GE(found, 0);
  EXPECT_LE(found, 78);
  EXPECT_EQ(result.tracks.back().state, TrackState::kTracking);
  EXPECT_LT(result.AteLive(), 0.006);
}

TEST(TrackerTest, AnotherPlaceIsNotMistakenForTheMap) {
  const TexturedRoom room({.seed = 1}), elsewhere({.seed = 9});
  Tracker tracker(kSmall, kSmallRepeatable);
  const auto make = [&](int k) {
    return (k < 60 ? room : elsewhere).Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), kSmall);
  };
  const Result result = TrackFrames(tracker, 0, 90, make);
  EXPECT_EQ(result.tracks[59].state, TrackState::kTracking);
  for (int k = 62; k < 90; ++k)
    EXPECT_EQ(result.tracks[static_cast<std::size_t>(k)].state, TrackState::kLost) << "frame " << k;
}

TEST(TrackerTest, TheSameFramesGiveTheSamePosesTwice) {
  const TexturedRoom room({});
  std::vector<Result> results;
  for (int round = 0; round < 2; ++round) {
    Tracker tracker(kSmall, kSmallRepeatable);
    results.push_back(
        TrackFrames(tracker, 0, 60, [&](int k) { return room.Take(TexturedRoom::HandAt(k), k, kSmall); }));
  }
  ASSERT_EQ(results[0].live.size(), results[1].live.size());
  ASSERT_GT(results[0].live.size(), 20u);
  for (std::size_t i = 0; i < results[0].live.size(); ++i) {
    EXPECT_EQ(results[0].live[i].cam_from_world.Matrix(), results[1].live[i].cam_from_world.Matrix()) << i;
    EXPECT_EQ(results[0].final[i].cam_from_world.Matrix(), results[1].final[i].cam_from_world.Matrix()) << i;
  }
}

TEST(TrackerTest, TracksWithTheMapperInItsOwnThread) {
  const TexturedRoom room({});
  Tracker tracker(kSmall, {.features = 500, .wait_for_mapper = true});
  const Result result =
      TrackFrames(tracker, 0, 90, [&](int k) { return room.Take(TexturedRoom::HandAt(k), k, kSmall); });
  ASSERT_GE(result.first_tracked, 0);
  EXPECT_EQ(result.Tracked(), 90 - result.first_tracked);
  EXPECT_LT(result.AteFinal(), 0.004);
  EXPECT_EQ(tracker.Statistics().keyframes_left_out, 0) << "a replay can wait";
}

TEST(TrackerTest, IncompleteFramesChangeNothing) {
  const TexturedRoom room({});
  Tracker tracker(kSmall, kSmallRepeatable);
  const auto make = [&](int k) {
    Frame frame = room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), kSmall);
    if (k % 7 == 3) frame.status = FrameStatus::kIncomplete;
    if (k == 45) frame.image.pixels.release();
    return frame;
  };
  TrackState before = TrackState::kInitializing;
  for (int k = 0; k < 60; ++k) {
    const Track track = tracker.Step(make(k));
    EXPECT_EQ(track.skipped, k % 7 == 3 || k == 45) << k;
    if (track.skipped) {
      EXPECT_EQ(track.state, before);
      EXPECT_FALSE(track.cam_from_world);
    }
    before = track.state;
  }
  EXPECT_EQ(before, TrackState::kTracking);
}

TEST(TrackerTest, WrongSizesAreErrorsThatSaySo) {
  Tracker tracker(TexturedRoom::Camera(), kRepeatable);
  Frame frame;
  frame.image.pixels = cv::Mat::zeros(100, 200, CV_8U);
  try {
    tracker.Step(frame);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("200x100"), std::string::npos) << error.what();
  }
  EXPECT_THROW(Tracker(CameraModel{}), Error);
}

TEST(TrackerTest, AMapSeededFromViewsIsFoundInItsWorld) {
  const TexturedRoom room({});
  std::vector<SeedView> views;
  for (int k = 0; k < 60; k += 8) {
    const Frame frame = room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), kSmall);
    views.push_back({frame.image, *frame.known_cam_from_world});
  }
  Tracker tracker(kSmall, kSmallRepeatable);
  ASSERT_TRUE(tracker.SeedMap(views));
  int tracked = 0;
  for (int k = 60; k < 100; ++k) {
    const Frame frame = room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), kSmall);
    const Track track = tracker.Step(frame);
    if (!track.cam_from_world) continue;
    ++tracked;
    // In the world of the seeds, metric: no alignment.
    EXPECT_LT((track.cam_from_world->OriginInSource() - frame.known_cam_from_world->OriginInSource()).norm(),
              0.01)
        << k;
  }
  EXPECT_GE(tracked, 38);
  tracker.Finish();
  for (std::size_t i = 0; i < views.size(); ++i)  // a view is a keyframe, in their order
    EXPECT_LT(
        (tracker.PoseOf({static_cast<int>(i), Rigid3{}}).Matrix() - views[i].cam_from_world.Matrix()).norm(),
        1e-9);
}

TEST(TrackerTest, SeedsThatShowNothingInCommonAreRefused) {
  const TexturedRoom one({.seed = 1}), other({.seed = 5});
  Tracker tracker(TexturedRoom::Camera(), kRepeatable);
  const Rigid3 a = TexturedRoom::HandAt(0), b = TexturedRoom::HandAt(20);
  EXPECT_FALSE(
      tracker.SeedMap(std::vector<SeedView>{{one.Take(a, 0).image, a}, {other.Take(b, 1).image, b}}));
  EXPECT_FALSE(tracker.SeedMap(std::vector<SeedView>{{one.Take(a, 0).image, a}}));
  EXPECT_EQ(tracker.Step(one.Take(a, 2)).state, TrackState::kInitializing);
}

// The sibling of the tests on real captures: the simulated hand before the simulated studio.
TEST(TrackerTest, FollowsTheSimulatedStudio) {
  const auto device = OpenDevice("sim:studio?seed=3&width=320&height=240");
  device->Start();
  Tracker tracker(*device->Camera(), kSmallRepeatable);
  const Result result =
      TrackFrames(tracker, 0, 110, [&](int) { return *device->Next(std::chrono::milliseconds(5000)); });
  ASSERT_GE(result.first_tracked, 0);
  EXPECT_LE(result.first_tracked, 40);
  EXPECT_GE(result.Tracked(), 0.98 * (110 - result.first_tracked));
  EXPECT_LT(result.AteLive(), 0.005);  // of a metre's distance
}

TEST(TrackCommand, ReportsAndWritesPoses) {
  const test::ScratchFolder folder;
  const auto run =
      test::RunUlf("track 'sim:studio?noise=0&width=320&height=240' --frames 30 --deterministic --json -o '" +
                   (folder / "live.txt").string() + "' --final '" + (folder / "final.txt").string() + "'");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto report = JsonFromText(run.output);
  for (const char* key : {"frames", "init_frame", "tracked", "lost_count", "relocalised_count", "ms_median",
                          "ms_p95", "cpu_ms_median", "cpu_ms_p95", "map_points", "keyframes", "ate_live_rmse",
                          "ate_final_rmse", "rpe_live_rmse", "rpe_final_rmse", "drift_live", "scale"})
    EXPECT_TRUE(report.contains(key)) << key;
  EXPECT_EQ(report["frames"], 30);
  EXPECT_EQ(ReadTum(folder / "live.txt").size(), report["tracked"].get<std::size_t>());
  EXPECT_EQ(ReadTum(folder / "final.txt").size(), report["tracked"].get<std::size_t>());
}

TEST(TrackCommand, BadArgumentsAreNamed) {
  const auto missing = test::RunUlf("track replay:/no/such/folder --focal-px 500");
  EXPECT_NE(missing.exit_code, 0);
  EXPECT_NE(missing.errors.find("/no/such/folder"), std::string::npos) << missing.errors;
  EXPECT_EQ(test::RunUlf("track nonsense:thing --focal-px 500").exit_code, 2);
  EXPECT_EQ(test::RunUlf("track sim:studio --frames -3").exit_code, 2);
}

// Little noise and many features, much noise and few: the quality value tells how far off the poses are.
TEST(TrackerTest, QualityPredictsTheError) {
  std::vector<test::PredictedError> errors = test::RoomErrors(2, 1000, 1, 130);
  for (const auto& error : test::RoomErrors(12, 300, 1, 130)) errors.push_back(error);
  ASSERT_GT(errors.size(), 200u);
  const std::vector<test::ErrorBin> bins = test::BinErrors(std::move(errors), 3);
  for (const test::ErrorBin& bin : bins) {
    std::printf("of the distance: predicted %.6f, true %.6f\n", bin.predicted, bin.actual);
    // No camera's lens is known as well as this one's: the prediction counts on a real one, and
    // is careful here.
    EXPECT_GT(bin.actual, bin.predicted / 6);
    EXPECT_LT(bin.actual, bin.predicted);
  }
  EXPECT_GT(bins.back().predicted, 2 * bins.front().predicted) << "it tells good frames from bad ones";
  EXPECT_GT(bins.back().actual, 2 * bins.front().actual);
}

}  // namespace
}  // namespace ulf::tracker_test
