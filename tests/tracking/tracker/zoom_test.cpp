// Tests: tracking/estimation/focal_change, tracking/tracker/zoom_watch, tracking/tracker/tracker_lens,
// tracking/map/mapper_lens.
// A zoom that is moved while the camera is followed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "acquisition/opening/open_device.h"
#include "core/geometry/trajectory.h"
#include "tests/support/test_run.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/estimation/focal_change.h"
#include "tracking/tracker/track.h"
#include "tracking/tracker/tracker.h"
#include "tracking/tracker/zoom_watch.h"

namespace ulf::test::zoom_test {
namespace {

using tracking::FocalChange;
using tracking::MeasureFocalChange;
using tracking::PointObservation;
using tracking::Tracker;
using tracking::ZoomWatch;

CameraModel Longer(CameraModel camera, double ratio) {
  camera.fx *= ratio;
  camera.fy *= ratio;
  return camera;
}

// What a camera sees of points between the given depths, with half a pixel of noise.
std::vector<PointObservation> SeenBy(const CameraModel& camera, double nearest, double farthest,
                                     unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(0, camera.width), y(0, camera.height), depth(nearest, farthest);
  std::normal_distribution<double> noise(0, 0.5);
  std::vector<PointObservation> seen;
  while (seen.size() < 300) {
    const Eigen::Vector3d ray = camera.RayFromImg({x(random), y(random)}).value();
    const Eigen::Vector3d point = ray / ray.z() * depth(random);
    seen.push_back({point, *camera.ImgFromCam(point) + Eigen::Vector2d(noise(random), noise(random)), 0.5});
  }
  return seen;
}

TEST(FocalChange, IsToldApartFromComingNearer) {
  const CameraModel camera = TexturedRoom::Camera();
  for (const double ratio : {0.93, 1.0, 1.08}) {
    const auto seen = SeenBy(Longer(camera, ratio), 1, 2, 7);
    // As a pose that was found with the camera's own focal length has it: nearer by as much.
    Rigid3 nearer;
    nearer.translation.z() = -1.5 * (ratio - 1);
    const auto change = MeasureFocalChange(camera, seen, nearer);
    ASSERT_TRUE(change);
    EXPECT_NEAR(change->log_ratio, std::log(ratio), 4 * change->sigma + 0.003) << ratio;
    EXPECT_LT(change->sigma, 0.005);
  }
  const CameraModel wall = camera;
  const auto flat = MeasureFocalChange(wall, SeenBy(Longer(wall, 1.08), 1.5, 1.5, 7), {});
  EXPECT_TRUE(!flat || flat->sigma > 0.02) << "a wall does not tell the two apart";
  EXPECT_FALSE(MeasureFocalChange(camera, {}, {}));
}

// What the watch says after frames with these changes, a thirtieth of a second apart.
struct Watched {
  ZoomWatch watch;
  int frames = 0;
  void Frames(int count, double log_ratio, double rows = 0) {
    for (int i = 0; i < count; ++i, ++frames)
      // As a tracker measures it, which follows with the focal length that the watch gives.
      watch.Step(frames / 30.0, FocalChange{log_ratio - watch.log_ratio(), 0.0005}, rows);
  }
};

TEST(ZoomWatch, AZoomIsMovedWhereFramesGoOnToDisagree) {
  Watched watched;
  watched.Frames(40, 0.001);
  EXPECT_FALSE(watched.watch.Disagrees());
  watched.Frames(3, 0.05);
  EXPECT_TRUE(watched.watch.Disagrees()) << "no keyframe";
  EXPECT_FALSE(watched.watch.IsMoved()) << "three frames may be wrong";
  watched.Frames(4, 0.05);
  ASSERT_TRUE(watched.watch.IsMoved());
  EXPECT_NEAR(watched.watch.log_ratio(), 0.049, 0.001);
  watched.Frames(10, 0.09);
  EXPECT_NEAR(watched.watch.log_ratio(), 0.089, 0.001) << "it is followed";
  watched.Frames(3, 0.002);
  EXPECT_FALSE(watched.watch.Disagrees()) << "it is back";
  EXPECT_EQ(watched.watch.log_ratio(), 0);
}

TEST(ZoomWatch, WrongLensOrRollingShutterIsNoZoom) {
  Watched bent;
  bent.Frames(40, 0.012);
  bent.Frames(10, -0.025);
  EXPECT_FALSE(bent.watch.IsMoved()) << "a map that disagrees all the time";
  Watched rows;
  rows.Frames(40, 0.001);
  rows.Frames(10, 0.04, 0.015);
  EXPECT_FALSE(rows.watch.Disagrees()) << "rows are not compensated, and the camera turns";
  Watched begun;
  begun.Frames(10, 0.001);
  begun.Frames(8, 0.04);
  EXPECT_FALSE(begun.watch.IsMoved()) << "too few frames before";
}

const CameraModel kSmall = TexturedRoom::Camera().ScaledTo(320, 240);

// Zooming during 20 frames each way.
double RatioAt(int frame, double zoomed) {
  const double there = std::clamp((frame - 60) / 20.0, 0.0, 1.0),
               back = std::clamp((frame - 100) / 20.0, 0.0, 1.0);
  return std::pow(zoomed, there - back);
}

TEST(ZoomWatch, TrackerFollowsAZoomAndKeepsItsMap) {
  const TexturedRoom room({.seed = 11});
  for (const double zoomed : {1.06, 0.9}) {
    SCOPED_TRACE(zoomed);
    Tracker tracker(kSmall, {.deterministic = true, .seed = 11, .features = 500});
    std::vector<TimedPose> found, truth;
    std::optional<int> first, last;
    for (int i = 0; i < 140; ++i) {
      const double ratio = RatioAt(i, zoomed);
      const Frame frame =
          room.Take(TexturedRoom::HandAt(i), static_cast<std::uint64_t>(i), Longer(kSmall, ratio));
      const tracking::Track track = tracker.Step(frame);
      EXPECT_FALSE(track.wrong_lens);
      EXPECT_FALSE(track.focal_ratio && track.keyframe);
      if (track.focal_ratio) {
        if (!first) first = i;
        last = i;
        if (i >= 85 && i < 100) {
          EXPECT_NEAR(*track.focal_ratio, zoomed, 0.008);
        }
      }
      truth.push_back({frame.device_time_s, TexturedRoom::HandAt(i)});
      if (track.focal_ratio) {
        EXPECT_LT(track.quality, 0.5) << "how far it was moved may be told wrong";
      }
      // While the zoom moves, and until it is known that it does, frames say that they are unsure.
      const bool rests = track.focal_ratio && i >= 85 && i < 100;
      if (track.cam_from_world && (track.quality > 0.5 || rests))
        found.push_back({frame.device_time_s, *track.cam_from_world});
    }
    ASSERT_TRUE(first && last);
    EXPECT_GE(*first, 61);
    EXPECT_LT(*first, 80) << "before it has come to rest";
    EXPECT_GE(*last, 105);
    EXPECT_LT(*last, 128) << "back again";
    EXPECT_GT(found.size(), 90u);
    const TrajectoryError error = CompareTrajectories(found, truth, 1e-6).value();
    EXPECT_LT(error.ate_rmse, 0.01) << "metres, of two to three to the wall";
    EXPECT_LT(error.ate_max, 0.04);
    tracker.Finish();
    EXPECT_FALSE(tracker.Statistics().calibration.value().Wrong()) << "no keyframe has another lens";
  }
}

// A young map under a wrong lens may hold until frames disagree with it: here before it was checked for
// the first time.
TEST(ZoomWatch, AnotherLensThanTheGivenOneIsNoZoom) {
  const auto device = acquisition::OpenDevice("sim:studio?seed=201&fault=lens=0.85");
  device->Start();
  const CameraModel given = *device->Camera();
  Tracker tracker(given, {.deterministic = true});
  bool is_contradicted = false;
  for (int i = 0; i < 80 && !is_contradicted; ++i) {
    const tracking::Track track = tracker.Step(device->Next(std::chrono::milliseconds(1000)).value());
    ASSERT_FALSE(track.focal_ratio) << "frame " << i;
    is_contradicted = track.wrong_lens;
  }
  ASSERT_TRUE(is_contradicted);
  const auto check = tracker.Statistics().calibration;
  ASSERT_TRUE(check);
  EXPECT_NEAR(check->fitted_focal_px, 0.85 * given.MeanFocalPx(), 0.02 * given.MeanFocalPx());
}

TEST(ZoomWatch, AFixedLensIsNotWatched) {
  const TexturedRoom room({.seed = 11});
  Tracker tracker(kSmall,
                  {.deterministic = true, .seed = 11, .features = 500, .lens = tracking::LensUse::kFixed});
  for (int i = 0; i < 100; ++i)
    EXPECT_FALSE(tracker
                     .Step(room.Take(TexturedRoom::HandAt(i), static_cast<std::uint64_t>(i),
                                     Longer(kSmall, RatioAt(i, 1.06))))
                     .focal_ratio);
}

TEST(ZoomWatch, WordsSayByHowMuch) {
  EXPECT_EQ(tracking::ZoomInWords(1.0994, FrameSource::kCamera),
            "the zoom was moved, or another lens is mounted: the focal length is 9.9 % longer than the given "
            "lens's; "
            "put it back, or calibrate");
  EXPECT_THAT(tracking::ZoomInWords(0.95, FrameSource::kCamera), ::testing::HasSubstr("5.0 % shorter"));
}

}  // namespace
}  // namespace ulf::test::zoom_test
