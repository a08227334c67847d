// Tests: tracking/tracker/photograph_locator.
// Photographs of another camera, located against the map that live view has made.
#include <gmock/gmock.h>

#include <map>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/tracker/tracker.h"

namespace ulf::photograph_locator_test {
namespace {

using test::TexturedRoom;

// Three times as fine, of another shape, its axis off the middle.
CameraModel PhotographCamera() {
  CameraModel camera = CameraModel::Pinhole(2040, 1360, 1590);
  camera.cx += 21;
  camera.cy -= 17;
  return camera;
}

// The room, followed by live view: once for all that ask for photographs in it.
struct Followed {
  Followed() {
    for (int k = 0; k < 90; ++k)
      tracks.push_back(tracker.Step(room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k))));
  }
  const TexturedRoom room{{}};
  Tracker tracker{TexturedRoom::Camera(), {.deterministic = true}};
  std::vector<Track> tracks;
};

class Photographs : public ::testing::Test {
 protected:
  static Followed& Live() {
    static Followed live;
    return live;
  }
  void SetUp() override { ASSERT_EQ(tracks_.back().state, TrackState::kTracking); }
  Frame Photograph(const Rigid3& cam_from_world, int id = 1000) const {
    return room_.Take(cam_from_world, static_cast<std::uint64_t>(id), PhotographCamera());
  }

  const TexturedRoom& room_ = Live().room;
  Tracker& tracker_ = Live().tracker;
  const std::vector<Track>& tracks_ = Live().tracks;
};

TEST_F(Photographs, AreLocatedAfterTheHandMovedOn) {
  std::vector<TimedPose> live, truth, photographs, without_hint;
  std::map<int, Rigid3> poses;
  for (int k = 30; k + 6 < 90; k += 5) {
    const Rigid3 taken_at = TexturedRoom::HandAt(k + 6);  // a fifth of a second after the pose that is known
    const Frame photograph = Photograph(taken_at, 1000 + k);
    const auto located = tracker_.Locate(photograph.image, PhotographCamera(),
                                         tracks_[static_cast<std::size_t>(k)].cam_from_world);
    ASSERT_TRUE(located) << "frame " << k;
    EXPECT_EQ(located->state, TrackState::kTracking);
    EXPECT_GT(located->quality, 0.5);
    ASSERT_TRUE(located->anchor);
    const Rigid3 anchored = tracker_.PoseOf(*located->anchor) * located->cam_from_world->Inverse();
    EXPECT_LT(RotationAngle(anchored.rotation) + anchored.translation.norm(), 1e-9);
    const auto found = tracker_.Locate(photograph.image, PhotographCamera());
    ASSERT_TRUE(found) << "frame " << k << ", without a hint";
    tracker_.NoteView(k, *located);
    poses[k] = tracker_.PoseOf(*located->anchor);
    const auto time_s = static_cast<double>(k);
    truth.push_back({time_s, taken_at});
    photographs.push_back({time_s, *located->cam_from_world});
    without_hint.push_back({time_s, *found->cam_from_world});
    live.push_back({time_s, *tracks_[static_cast<std::size_t>(k + 6)].cam_from_world});
  }
  const auto live_error = CompareTrajectories(live, truth, 0.1);
  const auto error = CompareTrajectories(photographs, truth, 0.1);
  const auto error_without_hint = CompareTrajectories(without_hint, truth, 0.1);
  RecordProperty("live_mm", std::to_string(1e3 * live_error->ate_rmse));
  RecordProperty("photographs_mm", std::to_string(1e3 * error->ate_rmse));
  EXPECT_LT(error->ate_rmse, 0.004) << "metres, 2.5 m away; live " << live_error->ate_rmse;
  EXPECT_LT(error->ate_rmse, 1.3 * live_error->ate_rmse);
  EXPECT_LT(error->rotation_rmse_deg, 0.1);
  EXPECT_LT(error_without_hint->ate_rmse, 0.004);
  // What they show of the map's points, in their own pixels: three of these are one of live view.
  EXPECT_GT(poses.size(), 10u);
  std::vector<double> errors_px;
  for (const ScenePoint& point : tracker_.Points())
    for (const ViewObservation& seen : point.track)
      errors_px.push_back(
          (*PhotographCamera().ImgFromCam(poses.at(seen.view_id) * point.position_in_world) - seen.in_img)
              .norm());
  EXPECT_GT(errors_px.size(), 100 * poses.size());
  EXPECT_LT(Median(errors_px), 1.5);
  EXPECT_LT(Quantile(errors_px, 0.95), 6);
}

TEST_F(Photographs, NothingOfTheTrackerChanges) {
  const auto points = tracker_.VisiblePoints().size();
  const auto keyframes = tracker_.Statistics().keyframes;
  ASSERT_TRUE(tracker_.Locate(Photograph(TexturedRoom::HandAt(40)).image, PhotographCamera()));
  EXPECT_EQ(tracker_.VisiblePoints().size(), points);
  EXPECT_EQ(tracker_.Statistics().keyframes, keyframes);
  EXPECT_EQ(tracker_.Step(room_.Take(TexturedRoom::HandAt(90), 90)).state, TrackState::kTracking);
}

TEST_F(Photographs, ShowingAnotherSceneAreNotLocated) {
  const TexturedRoom other({.seed = 99});
  for (const int k : {20, 50, 80}) {
    const Frame elsewhere = other.Take(TexturedRoom::HandAt(k), 1, PhotographCamera());
    EXPECT_FALSE(tracker_.Locate(elsewhere.image, PhotographCamera(),
                                 tracks_[static_cast<std::size_t>(k)].cam_from_world))
        << k;
  }
  Frame black = Photograph(TexturedRoom::HandAt(40));
  black.image.pixels.setTo(3);
  EXPECT_FALSE(tracker_.Locate(black.image, PhotographCamera(), tracks_[40].cam_from_world));
  // Turned away by half a turn.
  const Rigid3 away{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY())), {0, 0, 0}};
  EXPECT_FALSE(tracker_.Locate(Photograph(away * TexturedRoom::HandAt(40)).image, PhotographCamera(),
                               tracks_[40].cam_from_world));
}

// A wall of equal tiles of 0.4 m, photographed from most of a tile beside the pose that is known.
TEST(PhotographsOfTiles, AreRightOrNotLocated) {
  const TexturedRoom room({.furniture = test::Furniture::kTiles});
  Tracker tracker(TexturedRoom::Camera(), {.deterministic = true});
  Track last;
  constexpr int kLast = 59;
  for (int k = 0; k <= kLast; ++k)
    last = tracker.Step(room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k)));
  ASSERT_TRUE(last.cam_from_world);
  std::vector<double> units;  // of the map, by metre
  for (const double aside_m : {-0.3, -0.2, 0.2, 0.3}) {
    Rigid3 aside;
    aside.translation.x() = aside_m;
    const Frame photograph = room.Take(aside * TexturedRoom::HandAt(kLast), 1000, PhotographCamera());
    const auto located = tracker.Locate(photograph.image, PhotographCamera(), last.cam_from_world);
    if (!located) continue;
    const Rigid3 way = *located->cam_from_world * last.cam_from_world->Inverse();
    EXPECT_LT(RotationAngle(way.rotation), 0.01);
    units.push_back(way.translation.x() / aside_m);
  }
  ASSERT_GE(units.size(), 2u);
  for (const double unit : units) EXPECT_NEAR(unit, units.front(), 0.05 * units.front());
}

TEST_F(Photographs, WithIntrinsicsOfAnotherSizeAreAnError) {
  EXPECT_THAT(
      [&] { (void)tracker_.Locate(Photograph(TexturedRoom::HandAt(1)).image, TexturedRoom::Camera()); },
      ::testing::ThrowsMessage<Error>(::testing::HasSubstr("2040x1360")));
}

TEST(PhotographsWithoutAMap, AreNotLocated) {
  const TexturedRoom room({});
  Tracker tracker(TexturedRoom::Camera(), {.deterministic = true});
  tracker.Step(room.Take(TexturedRoom::HandAt(0), 0));
  EXPECT_FALSE(
      tracker.Locate(room.Take(TexturedRoom::HandAt(0), 1, PhotographCamera()).image, PhotographCamera()));
}

}  // namespace
}  // namespace ulf::photograph_locator_test
