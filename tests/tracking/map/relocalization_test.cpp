// Tests: tracking/map/pose_log_odds, tracking/map/map_matching, tracking/map/frame_locator.
// Found again, at once and never wrong: after shakes and occlusions, and where things look alike.
#include <gtest/gtest.h>

#include <functional>
#include <opencv2/imgproc.hpp>

#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tests/tracking/scenes/tiled_wall.h"
#include "tracking/map/frame_locator.h"
#include "tracking/map/pose_log_odds.h"
#include "tracking/tracker/tracker.h"

namespace ulf::relocalization_test {
namespace {

using Eigen::Vector3d;
using test::Draw;
using test::TexturedRoom;
using test::TiledWall;

// A pose that sees 30 points in each cell of its grid, of which `found(cell)` were.
double EvidenceOf(const std::function<int(int)>& found, const ExcludedCandidates& left_out = {}) {
  const CameraModel camera = test::SceneCamera();
  FramePose located;
  for (int cell = 0; cell < 12; ++cell)
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector2d img((cell % 4 + 0.5) * camera.width / 4.0 + i,
                                (cell / 4 + 0.5) * camera.height / 3.0);
      Candidate candidate;
      candidate.mean_direction.setZero();  // no match asks for it
      candidate.patch_axes.setZero();
      candidate.position = 2 * *camera.RayFromImg(img);
      candidate.find_rate = 0.8;
      located.looked_for.push_back(static_cast<int>(located.candidates.size()));
      if (i < found(cell)) located.matches.push_back({located.looked_for.back(), 0, img, 1, false});
      located.candidates.push_back(candidate);
    }
  return PoseLogOdds(camera, located, left_out);
}

TEST(PoseLogOddsTest, ForgivesAHandAndNotThinSupport) {
  const double all = EvidenceOf([](int) { return 24; });
  const double quarter = EvidenceOf([](int cell) { return cell % 4 == 0 ? 24 : 0; });
  EXPECT_GT(all, 3 * kRelocalizedLogOdds);
  EXPECT_GT(quarter, kRelocalizedLogOdds / 2);
  // As many points, spread thinly over the picture.
  EXPECT_LT(EvidenceOf([](int) { return 6; }), quarter);
  EXPECT_LT(EvidenceOf([](int) { return 2; }), kFollowedLogOdds) << "by chance";
  EXPECT_LT(EvidenceOf([](int) { return 0; }), kFollowedLogOdds);
}

TEST(PoseLogOddsTest, RepetitiveMatchesDoNotCount) {
  ExcludedCandidates repeats(12 * 30, false);
  for (std::size_t i = 0; i < repeats.size(); ++i) repeats[i] = i % 30 < 20;
  EXPECT_GT(EvidenceOf([](int) { return 28; }, repeats), kRelocalizedLogOdds) << "the rest is found";
  EXPECT_LT(EvidenceOf([](int) { return 20; }, repeats), kFollowedLogOdds) << "the rest is not";
  EXPECT_LT(EvidenceOf([](int) { return 24; }, ExcludedCandidates(12 * 30, true)), kRelocalizedLogOdds)
      << "nothing is left";
}

struct Answers {
  int right = 0, wrong = 0, none = 0;
};

Answers Ask(const TiledWall& wall, double from, double to, unsigned seed) {
  Draw draw(seed + 100);
  Answers answers;
  constexpr int kQuestions = 8;
  for (int i = 0; i < kQuestions; ++i) {
    const Rigid3 truth = TiledWall::PoseAt(draw.Uniform(from, to), draw);
    const auto found = wall.Find(truth, draw);
    if (!found)
      ++answers.none;
    else if ((found->cam_from_world.OriginInSource() - truth.OriginInSource()).norm() < 0.05)
      ++answers.right;
    else
      ++answers.wrong;
  }
  return answers;
}

// Inside the map an answer is right or withheld, beyond it withheld.
TEST(RelocalizationTest, ATiledWallNeverGivesAWrongPose) {
  for (const unsigned period_cm : test::SeedsOf({80, 40, 100, 130, 200}))
    for (const double unique : {0.0, 0.1, 0.3, 0.6}) {
      const double period = 0.01 * period_cm;
      const TiledWall wall({.period = period, .unique_share = unique});
      // On the mapped part, and where the wall goes on beyond it.
      const Answers inside = Ask(wall, TiledWall::kWidth, TiledWall::kMapped - TiledWall::kWidth, 1);
      const Answers outside = Ask(wall, TiledWall::kMapped + TiledWall::kWidth, 2 * TiledWall::kMapped, 2);
      EXPECT_EQ(inside.wrong, 0) << "period " << period << ", unique " << unique;
      EXPECT_EQ(outside.wrong + outside.right, 0) << "period " << period << ", unique " << unique;
      if (unique >= 0.3) {
        EXPECT_EQ(inside.right, 8) << "period " << period << ", unique " << unique;
      }
      if (unique == 0) {
        EXPECT_EQ(inside.right, 0) << "by luck: nothing tells the tiles apart; period " << period;
      }
      std::printf("period %.1f, %3.0f %% unique: %d right, %d wrong, %d none; beyond the map %d wrong\n",
                  period, 100 * unique, inside.right, inside.wrong, inside.none, outside.wrong);
    }
}

// Tiles that the picture cannot tell apart: a board that says where to look can. What it says of a place that
// the map does not know is not believed.
TEST(RelocalizationTest, ChecksABoardsPoseFirst) {
  const TiledWall wall({.period = 0.8});
  Draw draw(5);
  for (int i = 0; i < 8; ++i) {
    const auto told_of = [&](const Rigid3& truth) {
      Rigid3 told = truth;
      told.translation += 0.01 * draw.Direction();
      return told;
    };
    const Rigid3 truth =
        TiledWall::PoseAt(draw.Uniform(TiledWall::kWidth, TiledWall::kMapped - TiledWall::kWidth), draw);
    EXPECT_FALSE(wall.Find(truth, draw)) << i;
    const auto found = wall.FindAt(truth, told_of(truth), draw);
    ASSERT_TRUE(found) << i;
    EXPECT_LT((found->cam_from_world.OriginInSource() - truth.OriginInSource()).norm(), 0.006) << i;
    const Rigid3 beyond =
        TiledWall::PoseAt(draw.Uniform(1.5 * TiledWall::kMapped, 2 * TiledWall::kMapped), draw);
    EXPECT_FALSE(wall.FindAt(beyond, told_of(beyond), draw)) << i;
    // Half a tile off: nothing is where the map has it.
    Rigid3 wrong = truth;
    wrong.translation.x() += 0.4 * TiledWall::kWidth;
    EXPECT_FALSE(wall.FindAt(truth, wrong, draw)) << i;
  }
}

// A quarter of the pixels: a third of the time.
const CameraModel kSmall = TexturedRoom::Camera().ScaledTo(320, 240);

// Shaken, covered by a hand, and then before another part of what has been seen.
TEST(RelocalizationTest, ShakesAndOcclusionsAreSurvived) {
  for (const unsigned seed : {1u}) {
    const TexturedRoom room({.seed = seed});
    Tracker tracker(kSmall, {.deterministic = true, .seed = seed, .features = 500});
    std::vector<TimedPose> live, truth;
    std::uint64_t id = 0;
    const auto step = [&](Frame frame) {
      frame.id = id;
      frame.device_time_s = static_cast<double>(id++) / 30;
      const Track track = tracker.Step(frame);
      truth.push_back({frame.device_time_s, *frame.known_cam_from_world});
      if (track.cam_from_world) live.push_back({frame.device_time_s, *track.cam_from_world});
      return track;
    };
    for (int k = 0; k < 70; ++k) step(room.Take(TexturedRoom::HandAt(k), id, kSmall));
    Draw draw(seed);
    for (int event = 0; event < 5; ++event) {
      const int next = static_cast<int>(draw.Uniform(20, 69));
      for (int k = 0; k < 4; ++k) {
        Frame frame = room.Take(TexturedRoom::HandAt(next + k), id, kSmall);
        if (event % 2 == 0)  // shaken
          cv::blur(frame.image.pixels, frame.image.pixels, {45, 7});
        else  // a hand before the lens
          frame.image.pixels(cv::Rect(0, 0, 300, 240)).setTo(60);
        const Track track = step(frame);
        EXPECT_FALSE(track.cam_from_world) << "seed " << seed << ", event " << event;
      }
      int waited = 0;
      while (waited < 3 && !step(room.Take(TexturedRoom::HandAt(next + waited), id, kSmall)).cam_from_world)
        ++waited;
      EXPECT_LT(waited, 3) << "seed " << seed << ", event " << event;
    }
    EXPECT_LT(CompareTrajectories(live, truth, 0.001)->ate_max, 0.02) << "seed " << seed;
  }
}

TEST(RelocalizationTest, ASavedMapIsFoundInAtOnce) {
  const test::ScratchFolder scratch;
  const TexturedRoom room({});
  Tracker first(kSmall, {.deterministic = true, .features = 500});
  Rigid3 expected;
  for (int k = 0; k < 60; ++k) {
    const Track track = first.Step(room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), kSmall));
    if (k == 40 && track.cam_from_world) expected = *track.cam_from_world;
  }
  first.Finish();
  first.SaveMap(scratch / "map.ulf", 5);
  Tracker second(kSmall, {.deterministic = true, .features = 500});
  EXPECT_TRUE(second.RestoreMap(scratch / "map.ulf", 6)) << "of other views";
  EXPECT_TRUE(second.RestoreMap(scratch / "none.ulf", 5));
  EXPECT_EQ(second.Step(room.Take(TexturedRoom::HandAt(40), 1, kSmall)).state, TrackState::kInitializing);
  ASSERT_FALSE(second.RestoreMap(scratch / "map.ulf", 5));
  EXPECT_EQ(second.Statistics().map_points, first.Statistics().map_points);
  for (int k = 40; k < 70; ++k) {
    const Track track =
        second.Step(room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), kSmall));
    ASSERT_TRUE(track.cam_from_world) << k;
    if (k == 40) {
      EXPECT_LT((track.cam_from_world->OriginInSource() - expected.OriginInSource()).norm(), 0.01);
    }
  }
  EXPECT_GT(second.Statistics().keyframes, 2);
}

}  // namespace
}  // namespace ulf::relocalization_test
