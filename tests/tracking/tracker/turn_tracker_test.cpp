// Tests: tracking/tracker/turn_tracker, tracking/tracker/track.
// How a camera is turned is known before a map starts and while the camera is lost.
#include "tracking/tracker/turn_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/angles.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/tracker/track.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test::turn_tracker_test {
namespace {

using namespace tracking;

const CameraModel kTurnCamera = TexturedRoom::Camera().ScaledTo(320, 240);

double TurnErrorDeg(const Eigen::Quaterniond& turn, const Rigid3& truth, const Rigid3& truth_at_start) {
  return Degrees(RotationAngle(turn * (truth.rotation * truth_at_start.rotation.conjugate()).conjugate()));
}

TEST(TurnTrackerTest, TurningCameraHasATurnAndNoPose) {
  const TexturedRoom room({});
  Tracker tracker(kTurnCamera, {.deterministic = true, .features = 500});
  for (int k = 0; k < 90; ++k) {
    const Track track =
        tracker.Step(room.Take(TexturedRoom::TurningAt(k), static_cast<std::uint64_t>(k), kTurnCamera));
    ASSERT_FALSE(track.cam_from_world);
    ASSERT_TRUE(track.turn) << k;
    EXPECT_LT(TurnErrorDeg(*track.turn, TexturedRoom::TurningAt(k), TexturedRoom::TurningAt(0)), 0.3) << k;
  }
}

// Begun on the spot with 20 cm of sway: a turn until there is a pose. The sway looks like a turn by as much
// parallax as it makes before the map starts.
TEST(TurnTrackerTest, KnowsTheTurnFromTheFirstFrame) {
  const TexturedRoom room({.furniture = Furniture::kRound, .seed = 3});
  Tracker tracker(kTurnCamera, {.deterministic = true, .features = 500});
  int without_pose = 0, known = 0, k = 0;
  for (; k < 120; ++k) {
    const Rigid3 truth = TexturedRoom::TurningAndSwayingAt(k);
    const Track track = tracker.Step(room.Take(truth, static_cast<std::uint64_t>(k), kTurnCamera));
    if (track.cam_from_world) break;
    ++without_pose;
    known += track.turn.has_value();
    if (!track.turn) continue;
    EXPECT_LT(TurnErrorDeg(*track.turn, truth, TexturedRoom::TurningAndSwayingAt(0)), 2) << k;
  }
  EXPECT_LT(k, 90) << "the map starts within three seconds";
  EXPECT_EQ(known, without_pose);
}

// From a mapped place by a turn alone to where nothing is mapped, and back.
TEST(TurnTrackerTest, WhileTheCameraIsLostTheTurnGoesOn) {
  const TexturedRoom room({.furniture = Furniture::kRound});
  constexpr int kMapped = 60, kFrames = 150;
  const auto pose_at = [&](int k) {
    const int sway = std::min(k, kMapped), turned = std::clamp(k - kMapped, 0, 90);
    const double pan = 150 * std::sin(M_PI * turned / 90) * M_PI / 180;
    const Eigen::Vector3d center(0.3 * std::sin(0.08 * sway), 0.1 * std::sin(0.05 * sway), 0);
    return Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(pan, Eigen::Vector3d::UnitY())), center}.Inverse();
  };
  Tracker tracker(kTurnCamera, {.deterministic = true, .features = 500, .begin_parts = false});
  std::optional<Rigid3> world_from_truth;  // of the last pose before the turn: turns only
  int lost = 0, known = 0;
  bool said = false;
  Track track;
  for (int k = 0; k < kFrames; ++k) {
    const Rigid3 truth = pose_at(k);
    track = tracker.Step(room.Take(truth, static_cast<std::uint64_t>(k), kTurnCamera));
    if (track.cam_from_world && !world_from_truth && k == kMapped)
      world_from_truth = track.cam_from_world->Inverse() * truth;
    if (k <= kMapped || track.cam_from_world) continue;
    ASSERT_TRUE(world_from_truth);
    ++lost;
    known += track.turn.has_value();
    if (!track.turn) continue;
    said = said || InWords(track, FrameSource::kCamera).find("move sideways") != std::string::npos;
    const Eigen::Quaterniond expected = (truth * world_from_truth->Inverse()).rotation;
    EXPECT_LT(Degrees(RotationAngle(*track.turn * expected.conjugate())), 1) << k;
  }
  EXPECT_GT(lost, 20);
  EXPECT_GE(known, 0.9 * lost);
  EXPECT_TRUE(said);
  EXPECT_TRUE(track.cam_from_world) << "found again where the map is";
}

// Elsewhere another part of the map begins and is lost within its first frames: how the camera is turned from
// where it had a pose is as unknown as before.
TEST(TurnTrackerTest, APartThatIsLostAtOnceMakesNoTurn) {
  const TexturedRoom room({.furniture = Furniture::kRound});
  Tracker tracker(kTurnCamera, {.deterministic = true, .features = 500});
  const auto pose_at = [](double x, double pan_deg) {
    const Eigen::AngleAxisd pan(Radians(pan_deg), Eigen::Vector3d::UnitY());
    return Rigid3{Eigen::Quaterniond(pan), {x, 0.1 * std::sin(3 * x), 0}}.Inverse();
  };
  std::optional<Rigid3> world_from_truth;
  int apart = 0, after = 0;
  for (int k = 0; k < 190; ++k) {
    const bool elsewhere = k > 60;
    const Rigid3 truth =
        elsewhere ? pose_at(std::min(0.01 * (k - 60), 0.5), 150) : pose_at(0.3 * std::sin(0.08 * k), 0);
    Frame frame = room.Take(truth, static_cast<std::uint64_t>(k), kTurnCamera);
    if (apart >= 4 && after < 40) frame.image.pixels.setTo(0), ++after;
    const Track track = tracker.Step(frame);
    if (track.cam_from_world && !elsewhere) world_from_truth = track.cam_from_world->Inverse() * truth;
    apart += track.state == TrackState::kApart;
    if (!elsewhere || !track.turn || track.cam_from_world) continue;
    ASSERT_TRUE(world_from_truth);
    const Eigen::Quaterniond expected = (truth * world_from_truth->Inverse()).rotation;
    EXPECT_LT(Degrees(RotationAngle(*track.turn * expected.conjugate())), 3) << k;
  }
  EXPECT_GE(apart, 4);
  EXPECT_EQ(after, 40);
}

// A picture of something else is no turn.
TEST(TurnTrackerTest, UnrelatedFramesGiveNoTurn) {
  FeatureExtractor extractor(kTurnCamera, FeatureOptions{});
  const auto features_of = [&](unsigned seed) {
    const TexturedRoom room({.furniture = Furniture::kWall, .seed = seed});
    const Frame frame = room.Take(TexturedRoom::TurningAt(0), 0, kTurnCamera);
    return std::make_shared<const FeatureSet>(extractor.Extract(BuildPyramid(frame.image.pixels), 500));
  };
  TurnTracker turns(kTurnCamera, 1);
  EXPECT_TRUE(turns.Step(features_of(1)));
  EXPECT_TRUE(turns.Step(features_of(1)));
  EXPECT_FALSE(turns.Step(features_of(2)));
  EXPECT_TRUE(turns.Step(features_of(1)));
}

}  // namespace
}  // namespace ulf::test::turn_tracker_test
