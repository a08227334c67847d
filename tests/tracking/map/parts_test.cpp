// Tests: tracking/tracker/tracker_parts, tracking/tracker/tracker_core, tracking/map/loop_closer,
// tracking/map/map.
// A camera that is lost for good begins another part of the map; parts are joined when a place is
// seen from both.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/tracker/track.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test::parts_test {
namespace {

using namespace tracking;

// Frames that are taken on the way round a room, in any order, 30 a second.
struct RoomRun {
  std::vector<Track> tracks;
  std::vector<TimedPose> live, final, truth;
  Tracker tracker;

  RoomRun(const std::vector<int>& frames, const TrackerOptions& options, unsigned other_room_from = 1000)
      : tracker(Camera(), options) {
    const TexturedRoom room({.furniture = Furniture::kRound}),
        other({.furniture = Furniture::kRound, .seed = 7});
    for (unsigned i = 0; i < frames.size(); ++i) {
      const Rigid3 pose = TexturedRoom::RoundAt(frames[i]);
      tracks.push_back(tracker.Step((i < other_room_from ? room : other).Take(pose, i, Camera())));
      truth.push_back({i / 30.0, pose});
      if (tracks.back().cam_from_world) live.push_back({i / 30.0, *tracks.back().cam_from_world});
    }
    tracker.Finish();
    for (unsigned i = 0; i < tracks.size(); ++i)
      if (const auto pose = tracker.PoseNow(tracks[i]); pose && tracker.MapNow(tracks[i]) == MainMap())
        final.push_back({i / 30.0, *pose});
  }

  static CameraModel Camera() { return TexturedRoom::Camera().ScaledTo(320, 240); }
  int MainMap() const {
    const auto last = std::find_if(tracks.rbegin(), tracks.rend(),
                                   [](const Track& track) { return track.cam_from_world.has_value(); });
    return last == tracks.rend() ? -1 : last->map_id;
  }
  int Apart() const {
    return static_cast<int>(std::count_if(
        tracks.begin(), tracks.end(), [](const Track& track) { return track.state == TrackState::kApart; }));
  }
  double FinalError() const { return CompareTrajectories(final, truth, 0.001)->ate_rmse; }
};

std::vector<int> FromTo(std::initializer_list<std::pair<int, int>> ranges) {
  std::vector<int> frames;
  for (const auto& [from, to] : ranges)
    for (int k = from; k != to; k += from < to ? 1 : -1) frames.push_back(k);
  return frames;
}

constexpr TrackerOptions kInOneThread{.deterministic = true, .features = 500};

// The second part is followed for longer before they meet, so that the first one is moved into its world.
TEST(Parts, PartAfterACutJoinsWhereItMeetsTheFirst) {
  const RoomRun run(FromTo({{0, 110}, {190, 400}}), kInOneThread);
  EXPECT_GE(run.Apart(), 60);
  for (const Track& track : run.tracks) {
    if (track.state != TrackState::kApart) continue;
    EXPECT_FALSE(track.cam_from_world);
    EXPECT_TRUE(track.anchor);
    EXPECT_EQ(track.quality, 0);
    EXPECT_NE(InWords(track, FrameSource::kCamera).find("apart"), std::string::npos);
  }
  const TrackerStatistics statistics = run.tracker.Statistics();
  EXPECT_EQ(statistics.parts_joined, 1);
  EXPECT_EQ(statistics.parts, 1);
  EXPECT_EQ(run.tracks.back().state, TrackState::kTracking);
  // Frames that had no live pose, or one in the other world, have one now.
  EXPECT_GE(run.final.size(), run.live.size() + static_cast<std::size_t>(run.Apart()));
  EXPECT_LT(run.FinalError(), 0.01);
}

// The camera returns to the main part, and joins from there: the other part moves, though it is
// the newer one.
TEST(Parts, ThePartThatWasLeftIsJoinedFromTheMainOne) {
  const RoomRun run(FromTo({{0, 110}, {190, 280}, {60, 230}}), kInOneThread);
  EXPECT_EQ(run.tracker.Statistics().parts_joined, 1);
  EXPECT_EQ(run.tracker.Statistics().parts, 1);
  EXPECT_LT(run.FinalError(), 0.01);
}

TEST(Parts, TheMapperInItsOwnThreadJoinsToo) {
  const RoomRun run(FromTo({{0, 110}, {190, 400}}), {.features = 500, .wait_for_mapper = true});
  EXPECT_EQ(run.tracker.Statistics().parts_joined, 1);
  EXPECT_LT(run.FinalError(), 0.01);
}

TEST(Parts, AnotherRoomStaysApart) {
  const RoomRun run(FromTo({{0, 60}, {60, 130}}), kInOneThread, 60);
  EXPECT_GE(run.Apart(), 15);
  EXPECT_EQ(run.tracker.Statistics().parts_joined, 0);
  EXPECT_EQ(run.tracker.Statistics().parts, 2);
}

TEST(Parts, WithoutBeginningOthersTheCameraStaysLost) {
  TrackerOptions options = kInOneThread;
  options.begin_parts = false;
  const RoomRun run(FromTo({{0, 60}, {190, 260}}), options);
  EXPECT_EQ(run.Apart(), 0);
  EXPECT_EQ(run.tracks.back().state, TrackState::kLost);
  EXPECT_EQ(run.tracker.Statistics().parts, 1);
}

// A part that is followed for longer takes the main one's place, as long as no view lies in the
// main one's world.
TEST(Parts, MainPartIsTheLongerOrTheRecordedOne) {
  const TexturedRoom room({.furniture = Furniture::kRound}),
      other({.furniture = Furniture::kRound, .seed = 7});
  for (const bool recorded : {false, true}) {
    Tracker tracker(RoomRun::Camera(), kInOneThread);
    std::vector<Track> tracks;
    for (int i = 0; i < 170; ++i) {
      tracks.push_back(tracker.Step(
          (i < 50 ? room : other)
              .Take(TexturedRoom::RoundAt(i), static_cast<std::uint64_t>(i), RoomRun::Camera())));
      if (recorded && i == 40) tracker.NoteView(1, tracks.back());
    }
    ASSERT_TRUE(tracks[40].cam_from_world);
    EXPECT_EQ(tracks.back().state, recorded ? TrackState::kApart : TrackState::kTracking);
    EXPECT_NE(tracks.back().map_id, tracks[40].map_id);
    EXPECT_EQ(tracker.VisiblePoints().empty(), recorded);
    EXPECT_EQ(tracker.ExpectedPoints().empty(), recorded);
    // The earlier poses keep their world.
    EXPECT_EQ(tracker.MapNow(tracks[40]), tracks[40].map_id);
    EXPECT_LT(
        (tracker.PoseNow(tracks[40])->OriginInSource() - tracks[40].cam_from_world->OriginInSource()).norm(),
        0.05);
    // Points() are those of the main part: recorded views see some of them.
    const std::vector<ScenePoint> points = tracker.Points();
    EXPECT_GT(points.size(), 100u);
    EXPECT_EQ(std::any_of(points.begin(), points.end(), [](const ScenePoint& p) { return !p.track.empty(); }),
              recorded);
  }
}

}  // namespace
}  // namespace ulf::test::parts_test
