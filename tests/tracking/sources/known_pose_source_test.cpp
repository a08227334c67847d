// Tests: tracking/sources/known_pose_source, tracking/sources/pose_sources, tracking/tracker/pose_source.
#include <gtest/gtest.h>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::known_pose_source_test {
namespace {

using test::TexturedRoom;

Frame FrameAt(int k) {
  static const TexturedRoom room{{}};
  Frame frame = room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k));
  frame.known_cam_from_world = TexturedRoom::HandAt(k);
  return frame;
}

TEST(KnownPoseSource, GivesPosesAndTheSubjectsImageSpeed) {
  const CameraModel camera = TexturedRoom::Camera();
  const auto source = MakeKnownPoseSource(camera, Subject{{0, 0, 2}, 0.3});
  EXPECT_EQ(source->Step(FrameAt(0)).speed_px, 0) << "there is no frame before";
  Frame moved = FrameAt(0);
  Rigid3 aside = TexturedRoom::HandAt(0);
  aside.translation.x() += 0.02;
  moved.known_cam_from_world = aside;
  const Track track = source->Step(moved);
  ASSERT_TRUE(track.cam_from_world);
  EXPECT_EQ(track.cam_from_world->translation, aside.translation);
  EXPECT_EQ(track.state, TrackState::kTracking);
  const double distance = (TexturedRoom::HandAt(0) * Eigen::Vector3d(0, 0, 2)).norm();
  EXPECT_NEAR(track.speed_px, 520 * 0.02 / distance, 0.2 * 520 * 0.02 / distance);
  EXPECT_EQ(source->PoseOf(*track.anchor).translation, aside.translation);
}

TEST(KnownPoseSource, AFrameWithoutAPoseIsLost) {
  const auto source = MakeKnownPoseSource(TexturedRoom::Camera());
  Frame frame = FrameAt(0);
  frame.known_cam_from_world.reset();
  EXPECT_EQ(source->Step(frame).state, TrackState::kLost);
  EXPECT_FALSE(source->Locate(frame, TexturedRoom::Camera(), {}));
}

TEST(TrackerPoseSource, IsTheTracker) {
  const TexturedRoom room{{}};
  const CameraModel camera = TexturedRoom::Camera().ScaledTo(320, 240);
  const TrackerOptions options{.deterministic = true, .features = 500};
  Tracker tracker(camera, options);
  const auto source = MakeTrackerSource(camera, options);
  for (int k = 0; k < 45; ++k) {
    const Frame frame = room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), camera);
    const Track own = tracker.Step(frame), given = source->Step(frame);
    ASSERT_EQ(own.cam_from_world.has_value(), given.cam_from_world.has_value()) << k;
    if (own.cam_from_world) {
      EXPECT_EQ(own.cam_from_world->translation, given.cam_from_world->translation) << k;
    }
  }
  tracker.Finish();
  source->Finish();
  EXPECT_GT(source->Points().size(), 100u);
  EXPECT_EQ(source->Points().size(), tracker.Points().size());
  EXPECT_EQ(source->Statistics().keyframes, tracker.Statistics().keyframes);
}

}  // namespace
}  // namespace ulf::known_pose_source_test
