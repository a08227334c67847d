// Tests: tracking/map/fiducial_observation, tracking/tracker/working_size.
// Pictures larger than the working size: tracked as smaller ones are, everything outside in their own pixels.
#include "tracking/tracker/working_size.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <opencv2/imgproc.hpp>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/tracker/tracker.h"

namespace ulf::working_size_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::TexturedRoom;

TEST(WorkingSize, PointsAndCameraScaleFromEdgeToEdge) {
  const CameraModel original = CameraModel::FromOpenCv(
      1003, 751, 830, 832, 498, 377, Distortion::kRadialTangential, {-0.2, 0.05, 1e-3, 2e-3});
  for (const int side : {1003, 640, 333}) {
    const WorkingSize size(original, side);
    EXPECT_EQ(size.working().width, side);
    EXPECT_EQ(size.working().height, std::lround(751.0 * side / 1003));
    EXPECT_EQ(size.IsReduced(), side < 1003);
    EXPECT_EQ(size.working().coefficients, original.coefficients);
    EXPECT_DOUBLE_EQ(size.working().cx / size.working().width, original.cx / original.width);
    EXPECT_DOUBLE_EQ(size.working().cy / size.working().height, original.cy / original.height);
    for (const Vector3d& point : {Vector3d(0.3, -0.2, 1), Vector3d(-0.4, 0.3, 1.1), Vector3d(0, 0, 2)})
      EXPECT_LT((size.ToOriginal(*size.working().ImgFromCam(point)) - *original.ImgFromCam(point)).norm(),
                1e-9);
    const FiducialObservation fiducials =
        size.Reduced(FiducialObservation{{{Vector3d(0, 0, 1), {1003, 751}, 0.3}}, {}, 0.1});
    EXPECT_NEAR(fiducials.corners[0].img.x(), size.working().width, 1e-9);
    EXPECT_NEAR(fiducials.corners[0].img.y(), size.working().height, 1e-9);
    EXPECT_NEAR(size.ToOriginal(fiducials.corners[0].sigma_px), 0.3, 1e-9);
  }
  // Portrait: the longer side.
  EXPECT_EQ(WorkingSize(CameraModel::Pinhole(1080, 1920, 1500), 640).working().width, 360);
  for (const int side : {0, 2000}) EXPECT_EQ(WorkingSize(original, side).working(), original) << side;
}

// A disc's middle stays where the sizes' ratio puts it, at ratios that are no whole numbers, and fine stripes
// become grey, not coarser stripes.
TEST(WorkingSize, PicturesAreReducedWithoutAliasing) {
  for (const int side : {640, 450, 233}) {
    const WorkingSize size(CameraModel::Pinhole(1001, 700, 800), side);
    cv::Mat disc(700, 1001, CV_8U, cv::Scalar(0));
    cv::circle(disc, {613, 241}, 60, cv::Scalar(200), cv::FILLED);
    const cv::Moments of_disc = cv::moments(size.Reduced(disc));
    const Vector2d middle =
        size.ToOriginal(Vector2d(of_disc.m10 / of_disc.m00 + 0.5, of_disc.m01 / of_disc.m00 + 0.5));
    EXPECT_LT((middle - Vector2d(613.5, 241.5)).norm(), 0.1) << side;
    if (side > 500) continue;  // a pixel covers less than two stripes
    cv::Mat stripes(700, 1001, CV_8U);
    for (int x = 0; x < stripes.cols; ++x) stripes.col(x).setTo(x % 2 ? 255 : 0);
    cv::Scalar mean, deviation;
    cv::meanStdDev(size.Reduced(stripes), mean, deviation);
    EXPECT_NEAR(mean[0], 127.5, 2) << side;
    EXPECT_LT(deviation[0], 40) << side;
  }
  const cv::Mat picture(480, 640, CV_8U, cv::Scalar(7));
  EXPECT_EQ(WorkingSize(CameraModel::Pinhole(640, 480, 500), 640).Reduced(picture).data, picture.data);
}

struct RoomRun {
  std::vector<TimedPose> live, final, truth;
  std::vector<Track> tracks;
  std::vector<VisiblePoint> visible;  // in the last frame
  TrackerStatistics statistics;
};

RoomRun Follow(const CameraModel& camera, int max_side_px, int frames,
               const std::function<Frame(int)>& frame_at) {
  Tracker tracker(camera, {.deterministic = true, .features = 600, .max_side_px = max_side_px});
  RoomRun run;
  std::vector<std::pair<double, Anchored>> anchors;
  for (int k = 0; k < frames; ++k) {
    const Frame frame = frame_at(k);
    run.tracks.push_back(tracker.Step(frame));
    if (frame.known_cam_from_world) run.truth.push_back({frame.device_time_s, *frame.known_cam_from_world});
    const Track& track = run.tracks.back();
    if (!track.cam_from_world) continue;
    run.live.push_back({frame.device_time_s, *track.cam_from_world});
    anchors.emplace_back(frame.device_time_s, *track.anchor);
  }
  run.visible = tracker.VisiblePoints();
  tracker.Finish();
  for (const auto& [time_s, anchor] : anchors) run.final.push_back({time_s, tracker.PoseOf(anchor)});
  run.statistics = tracker.Statistics();
  return run;
}

Frame Enlarged(Frame frame, double factor) {
  cv::Mat larger;
  cv::resize(GrayForTracking(frame.image), larger, {}, factor, factor, cv::INTER_CUBIC);
  frame.image = {.pixels = larger, .transfer = Transfer::kSrgb};
  return frame;
}

class EnlargedRoom : public testing::Test {
 protected:
  static constexpr int kFrames = 45;
  static constexpr double kFactor = 2;
  Frame SmallAt(int k) const {
    return room_.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), small_);
  }
  const TexturedRoom room_{{.noise = 1}};
  const CameraModel small_ = TexturedRoom::Camera().ScaledTo(320, 240), large_ = small_.ScaledTo(640, 480);
};

TEST_F(EnlargedRoom, IsFollowedInItsOwnPixels) {
  const RoomRun small = Follow(small_, 320, kFrames, [&](int k) { return SmallAt(k); });
  const RoomRun large = Follow(large_, 320, kFrames, [&](int k) { return Enlarged(SmallAt(k), kFactor); });
  ASSERT_GE(small.live.size(), 20u);
  ASSERT_GE(large.live.size() + 3, small.live.size());
  const auto error = CompareTrajectories(large.live, large.truth, 0.001);
  const auto small_error = CompareTrajectories(small.live, small.truth, 0.001);
  ASSERT_TRUE(error && small_error);
  EXPECT_LT(error->ate_rmse, 0.005) << "metres, 2.5 m away; as it comes " << small_error->ate_rmse;
  const auto apart = CompareTrajectories(large.final, small.final, 0.001);
  ASSERT_TRUE(apart);
  EXPECT_LT(apart->ate_rmse, 0.002) << "of the map's unit, the median depth";
  EXPECT_LT(apart->rotation_rmse_deg, 0.5);

  // What comes out is in the large picture's pixels.
  EXPECT_EQ(large.statistics.size.width, 320);
  EXPECT_EQ(large.statistics.size.original_width, 640);
  ASSERT_GT(large.visible.size(), 50u);
  const Rigid3& last = large.live.back().cam_from_world;
  int near = 0;
  for (const VisiblePoint& point : large.visible)
    if (const auto img = large_.ImgFromCam(last * point.position_in_world))
      near += (*img - point.img).norm() < 1.5 * kFactor;
  EXPECT_GT(near, 0.9 * static_cast<double>(large.visible.size()));
  const auto median_speed_px = [](const RoomRun& run) {
    std::vector<double> speeds;
    for (const Track& track : run.tracks)
      if (track.cam_from_world) speeds.push_back(track.speed_px);
    std::nth_element(speeds.begin(), speeds.begin() + static_cast<long>(speeds.size() / 2), speeds.end());
    return speeds[speeds.size() / 2];
  };
  EXPECT_NEAR(median_speed_px(large) / median_speed_px(small), kFactor, 0.1 * kFactor);
}

// Pictures no larger than the working size are tracked exactly as without one.
TEST_F(EnlargedRoom, SmallFramesAreTrackedUnreduced) {
  const RoomRun as_it_comes = Follow(small_, 0, 40, [&](int k) { return SmallAt(k); });
  const RoomRun by_default =
      Follow(small_, TrackerOptions{}.max_side_px, 40, [&](int k) { return SmallAt(k); });
  ASSERT_FALSE(by_default.final.empty());
  ASSERT_EQ(as_it_comes.final.size(), by_default.final.size());
  for (std::size_t i = 0; i < by_default.final.size(); ++i) {
    EXPECT_EQ(as_it_comes.final[i].cam_from_world.translation,
              by_default.final[i].cam_from_world.translation);
    EXPECT_EQ(as_it_comes.live[i].cam_from_world.translation, by_default.live[i].cam_from_world.translation);
  }
}

// A blur that is none at the working size is one of the picture that is recorded.
TEST_F(EnlargedRoom, SharpnessIsThatOfThePictureAsItComes) {
  const CameraModel camera = TexturedRoom::Camera().ScaledTo(1280, 960);
  Tracker tracker(camera, {.deterministic = true, .max_side_px = 160});
  for (int k = 0; k < 5; ++k) {
    Frame frame = room_.Take(TexturedRoom::HandAt(0), static_cast<std::uint64_t>(k), camera);
    if (k < 4) {
      EXPECT_GT(tracker.Step(frame).sharpness, 0.8) << k;
      continue;
    }
    cv::blur(frame.image.pixels, frame.image.pixels, {6, 6});
    EXPECT_LT(tracker.Step(frame).sharpness, 0.5);
  }
}

TEST_F(EnlargedRoom, RelocalisesAtTheMapsOwnSize) {
  const test::ScratchFolder scratch;
  const CameraModel camera = large_;
  const auto frame_at = [&](int k) {
    return room_.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), camera);
  };
  const TrackerOptions options{.deterministic = true, .features = 600, .max_side_px = 320};
  Tracker first(camera, options);
  std::vector<SeedView> seeds;
  for (int k = 0; k < 45; ++k) {
    const Frame frame = frame_at(k);
    const Track track = first.Step(frame);
    if (track.cam_from_world && k % 5 == 0) seeds.push_back({frame.image, *track.cam_from_world});
  }
  ASSERT_GE(seeds.size(), 3u);
  first.SaveMap(scratch / "map.ulf", 5);
  TrackerOptions other = options;
  other.max_side_px = 480;
  const auto refusal = Tracker(camera, other).RestoreMap(scratch / "map.ulf", 5);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->problem, MapProblem::kOtherViews);
  EXPECT_THAT(refusal->words, testing::HasSubstr("tracking_side"));

  Tracker restored(camera, options), seeded(camera, options);
  ASSERT_FALSE(restored.RestoreMap(scratch / "map.ulf", 5));
  ASSERT_TRUE(seeded.SeedMap(seeds));
  const Rigid3 expected = first.PoseOf(*first.Step(frame_at(45)).anchor);
  for (Tracker* tracker : {&restored, &seeded}) {
    const Track track = tracker->Step(frame_at(45));
    ASSERT_TRUE(track.cam_from_world);
    EXPECT_LT((track.cam_from_world->OriginInSource() - expected.OriginInSource()).norm(), 0.02);
  }
  // A photograph of another camera, finer than what is tracked.
  const CameraModel still = TexturedRoom::Camera().ScaledTo(1280, 960);
  const auto located = first.Locate(room_.Take(TexturedRoom::HandAt(45), 99, still).image, still);
  ASSERT_TRUE(located);
  EXPECT_LT((located->cam_from_world->OriginInSource() - expected.OriginInSource()).norm(), 0.01);
}

TEST_F(EnlargedRoom, RefusalNamesBothOriginalSizes) {
  Tracker tracker(large_, {.max_side_px = 320});
  EXPECT_THAT([&] { tracker.Step(SmallAt(0)); },
              testing::ThrowsMessage<Error>(
                  testing::AllOf(testing::HasSubstr("320x240"), testing::HasSubstr("640x480"))));
}

// Real pictures without detail at their own size: 6 of 80 frames were followed as they come.
TEST(WorkingSizeData, FollowsTheKitchenAt3840Pixels) {
  ULF_NEED_TEST_DATA(folder, "handheld_kitchen");
  constexpr int kFrames = 48;
  std::vector<RoomRun> runs;
  for (const double factor : {1.0, 6.0}) {
    const auto device = OpenDevice("replay:" + folder.string() + "?glob=*.color.jpg");
    device->Start();
    const CameraModel camera = ReadCalibration(folder / "intrinsics.txt");
    runs.push_back(Follow(
        camera.ScaledTo(static_cast<int>(factor * camera.width), static_cast<int>(factor * camera.height)),
        TrackerOptions{}.max_side_px, kFrames, [&](int) {
          const Frame frame = *device->Next(std::chrono::milliseconds(1000));
          return factor == 1 ? frame : Enlarged(frame, factor);
        }));
  }
  ASSERT_GE(runs[0].live.size(), 12u);
  EXPECT_GE(runs[1].live.size() + 5, runs[0].live.size());
  const auto apart = CompareTrajectories(runs[1].final, runs[0].final, 0.001);
  ASSERT_TRUE(apart);
  EXPECT_LT(apart->ate_rmse, 0.01) << "of the map's unit, the median depth";
}

}  // namespace
}  // namespace ulf::working_size_test
