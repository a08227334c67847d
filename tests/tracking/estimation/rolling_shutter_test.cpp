// Tests: tracking/estimation/rolling_shutter, tracking/tracker/readout, tracking/tracker/readout_search,
// tracking/tracker/row_motion.
#include "tracking/estimation/rolling_shutter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <random>

#include "acquisition/simulator/simulated_camera.h"
#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/tracker/row_motion.h"
#include "tracking/tracker/tracker.h"

namespace ulf::rolling_shutter_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kReadout_s = 0.02;

Twist QuickTurn() {  // 1 rad/s, while moving by a third of a metre per second
  Twist twist;
  twist << 0.3, 0.9, -0.2, 0.25, -0.1, 0.2;
  return twist;
}

CameraModel Camera() { return SimulatedIntrinsics(640, 480); }

// Where a sensor whose rows have poses of their own sees a point: the row that sees it where it is itself.
Vector2d SeenByRows(const CameraModel& camera, const Rigid3& pose, const Vector3d& point, double readout_s,
                    const Twist& twist) {
  Vector2d seen = *camera.ImgFromCam(pose * point);
  for (int i = 0; i < 50; ++i) {
    const double time_s = readout_s * (seen.y() / camera.height - 0.5);
    seen = *camera.ImgFromCam(Perturbed(pose, time_s * twist) * point);
  }
  return seen;
}

std::vector<Vector3d> PointsBefore(const CameraModel& camera, unsigned seed, int count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(20, camera.width - 20.0), y(20, camera.height - 20.0),
      depth(0.8, 3);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const Vector3d ray = *camera.RayFromImg({x(random), y(random)});
    points.push_back(ray / ray.z() * depth(random));
  }
  return points;
}

TEST(RowShiftTest, ProjectsAPointInAMovingCamera) {
  const CameraModel camera = Camera();
  const RowShift rows(camera, kReadout_s, QuickTurn(), DepthField(camera, {}));
  double largest_px = 0;
  for (const Vector3d& point : PointsBefore(camera, 1, 200)) {
    const Vector2d global = *camera.ImgFromCam(point);
    const Vector2d seen = SeenByRows(camera, Rigid3{}, point, kReadout_s, QuickTurn());
    EXPECT_LT((rows.Seen(global, point) - seen).norm(), 1e-3);
    EXPECT_LT((rows.Global(seen, point) - global).norm(), 1e-3);
    largest_px = std::max(largest_px, (seen - global).norm());
  }
  EXPECT_GT(largest_px, 4);  // there was something to be found
}

TEST(RowShiftTest, InterpolatesDepthsAndInverts) {
  const CameraModel camera = Camera();
  std::vector<DepthField::Sample> wall;  // slanted
  for (const Vector3d& point : PointsBefore(camera, 2, 2000))
    wall.push_back({*camera.ImgFromCam(point), 2 + 0.5 * camera.ImgFromCam(point)->x() / camera.width});
  const RowShift rows(camera, kReadout_s, QuickTurn(), DepthField(camera, wall));
  for (const Vector3d& direction : PointsBefore(camera, 3, 100)) {
    const Vector2d global = *camera.ImgFromCam(direction);
    const Vector3d point = direction / direction.z() * (2 + 0.5 * global.x() / camera.width);
    EXPECT_LT((rows.Seen(global) - rows.Seen(global, point)).norm(), 0.03);
    EXPECT_LT((rows.Global(rows.Seen(global)) - global).norm(), 1e-4);
  }
}

TEST(RowShiftTest, FindsVelocityWithAFifthOutliers) {
  const CameraModel camera = Camera();
  std::vector<PointFlow> flow;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 5);
  for (const Vector3d& point : PointsBefore(camera, 4, 300)) {
    constexpr double kStep_s = 1e-3;
    const Vector2d moved = *camera.ImgFromCam(Perturbed(Rigid3{}, kStep_s * QuickTurn()) * point);
    flow.push_back({point, (moved - *camera.ImgFromCam(point)) / kStep_s});
    flow.back().px_s += Vector2d(noise(random), noise(random));
    if (flow.size() % 5 == 0) flow.back().px_s = Vector2d(900, -700);
  }
  const auto twist = TwistFromFlow(camera, flow);
  ASSERT_TRUE(twist);
  EXPECT_LT((*twist - QuickTurn()).norm(), 0.03);
  EXPECT_FALSE(TwistFromFlow(camera, std::span(flow).first(5)));
}

TEST(RowShiftTest, PoseAndVelocityAreFoundFromOneFrame) {
  const CameraModel camera = Camera();
  const Rigid3 pose{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d::UnitY())), {0.1, -0.2, 0.4}};
  std::vector<SeenPoint> seen;
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.2);
  for (const Vector3d& in_cam : PointsBefore(camera, 6, 400)) {
    const Vector3d point = pose.Inverse() * in_cam;
    const Vector2d img = SeenByRows(camera, pose, point, kReadout_s, QuickTurn());
    seen.push_back({point, img + Vector2d(noise(random), noise(random)), 0.2});
    if (seen.size() % 10 == 0) seen.back().seen += Vector2d(30, 20);
  }
  const MotionPrior prior{Twist::Zero(), Twist::Constant(2)};
  Rigid3 near = pose;
  near.translation.x() += 0.01;
  const auto found = RefinePoseAndMotion(camera, kReadout_s, seen, near, prior);
  ASSERT_TRUE(found);
  EXPECT_LT((found->cam_from_world.OriginInSource() - pose.OriginInSource()).norm(), 1e-3);
  EXPECT_LT((found->twist - QuickTurn()).norm(), 0.12);
  // As a global shutter the same frame is seen from elsewhere.
  std::vector<PointObservation> observations;
  for (const SeenPoint& point : seen)
    observations.push_back({point.point_in_world, point.seen, point.sigma_px});
  const auto plain = RefinePose(camera, observations, near, {.gate_sigmas = 100});
  ASSERT_TRUE(plain);
  EXPECT_GT((plain->cam_from_world.OriginInSource() - pose.OriginInSource()).norm(), 3e-3);
}

double RmsPx(const CameraModel& camera, const Rigid3& pose, const std::vector<SeenPoint>& seen) {
  double sum = 0;
  for (const SeenPoint& point : seen)
    sum += (*camera.ImgFromCam(pose * point.point_in_world) - point.seen).squaredNorm();
  return std::sqrt(sum / static_cast<double>(seen.size()));
}

TEST(RowMotionTest, TellsPicturePoseFromMiddleRowPose) {
  const CameraModel camera = Camera();
  TrackedImage image;
  image.features = std::make_shared<const FeatureSet>(std::vector<Feature>{}, camera.width, camera.height);
  image.pyramid = std::make_shared<const Pyramid>();
  FramePose located;
  std::vector<SeenPoint> seen;
  for (const Vector3d& point : PointsBefore(camera, 8, 300)) {
    seen.push_back({point, SeenByRows(camera, Rigid3{}, point, kReadout_s, QuickTurn()), 0.4});
    located.candidates.emplace_back().position = point;
    located.matches.push_back({.candidate = static_cast<int>(located.matches.size()),
                               .feature = -1,
                               .img = seen.back().seen,
                               .sigma_px = 0.4});
  }
  RowMotion motion(camera, kReadout_s);
  motion.RefineWithRows(image, located, QuickTurn(), false);
  EXPECT_LT(located.cam_from_world.OriginInSource().norm(), 1e-3);
  const Rigid3 picture = located.picture_from_cam * located.cam_from_world;
  EXPECT_GT(picture.OriginInSource().norm(), 3e-3);
  EXPECT_LT(RmsPx(camera, picture, seen), 0.9 * RmsPx(camera, located.cam_from_world, seen));
  // No other pose does it better.
  for (int k = 0; k < 6; ++k)
    for (const double step : {-2e-3, 2e-3})
      EXPECT_GT(RmsPx(camera, Perturbed(picture, step * Twist::Unit(k)), seen), RmsPx(camera, picture, seen));
}

// The same hand before the same scene, by both shutters; rendered once.
const std::vector<Frame>& Frames(double readout_s) {
  static std::map<double, std::vector<Frame>> rendered;
  std::vector<Frame>& frames = rendered[readout_s];
  if (frames.empty()) {
    SimulationOptions options;
    options.width = 320;
    options.height = 240;
    options.readout_s = readout_s;
    options.looks_away = false;
    const SimulatedCamera camera(options);
    for (std::uint64_t i = 0; i < 105; ++i) frames.push_back(camera.Capture(i));
  }
  return frames;
}

struct Outcome {
  double error_m = 0;       // RMS of the centres of the middle rows, as given live
  double late_error_m = 0;  // the same of the last 35 frames
  std::optional<Readout> rolling;
};

// `pause_every`: so many frames apart, from the middle on, the mapper is waited for.
Outcome Follow(double readout_s, const TrackerOptions& options, std::size_t pause_every = 0) {
  Tracker tracker(SimulatedIntrinsics(320, 240), options);
  std::vector<TimedPose> given, truth;
  for (const Frame& frame : Frames(readout_s)) {
    const Track track = tracker.Step(frame);
    truth.push_back({frame.device_time_s, *frame.known_cam_from_world});
    if (pause_every > 0 && truth.size() > 40 && truth.size() % pause_every == 0) tracker.Finish();
    if (!track.cam_from_world) continue;
    given.push_back(
        {frame.device_time_s, track.middle_row_from_picture.value_or(Rigid3{}) * *track.cam_from_world});
  }
  const auto error = CompareTrajectories(given, truth, 0.01, 1);
  EXPECT_GT(given.size(), 85u);
  EXPECT_TRUE(error);
  const auto late =
      CompareTrajectories(std::span(given).last(std::min<std::size_t>(35, given.size())), truth, 0.01, 1);
  EXPECT_TRUE(late);
  return {error ? error->ate_rmse : 1e9, late ? late->ate_rmse : 1e9, tracker.Statistics().rolling_shutter};
}

// A map that goes on is an earlier session's: as long as its camera adds no keyframe, nothing is measured,
// and a global shutter must not be reckoned to roll.
TEST(RollingShutter, ContinuedMapSuspectsNone) {
  const CameraModel camera = SimulatedIntrinsics(320, 240);
  const test::ScratchFolder scratch;
  const std::vector<Frame>& frames = Frames(0);
  Tracker before(camera, {.deterministic = true, .readout = {.readout_s = 0}});
  for (std::size_t i = 0; i < 60; ++i) before.Step(frames[i]);
  before.Finish();
  before.SaveMap(scratch / "map.ulf", 1);
  double quality[2] = {};
  for (const bool told : {true, false}) {
    TrackerOptions options{.deterministic = true};
    if (told) options.readout.readout_s = 0;
    Tracker tracker(camera, options);
    ASSERT_FALSE(tracker.RestoreMap(scratch / "map.ulf", 1));
    tracker.Step(frames[57]);
    tracker.Step(frames[58]);
    quality[told] = tracker.Step(frames[59]).quality;
  }
  EXPECT_GT(quality[true], 0.5);
  EXPECT_DOUBLE_EQ(quality[false], quality[true]);
}

TEST(PointAfterTest, DerivativesMatchDifferences) {
  Twist twist;
  twist << 0.7, -1.2, 0.4, 0.3, -0.2, 0.5;
  const Eigen::Vector3d point(0.4, -0.3, 2);
  constexpr double kTime_s = 0.02, kStep = 1e-6;
  Eigen::Matrix3d by_point;
  Eigen::Matrix<double, 3, 6> by_twist;
  const Eigen::Vector3d after = PointAfter(twist, point, kTime_s, &by_point, &by_twist);
  for (int i = 0; i < 3; ++i)
    EXPECT_LT(((PointAfter(twist, point + kStep * Eigen::Vector3d::Unit(i), kTime_s) - after) / kStep -
               by_point.col(i))
                  .norm(),
              1e-5);
  for (int i = 0; i < 6; ++i)
    EXPECT_LT(((PointAfter(twist + kStep * Twist::Unit(i), point, kTime_s) - after) / kStep - by_twist.col(i))
                  .norm(),
              1e-5);
}

struct TurnOutcome {
  std::size_t given = 0;
  int wrong = 0,
      unsaid = 0;  // off by 3 % of the distance or 2 degrees; of these, with a quality of one half or more
  int recorded_wrong =
      0;              // pictures whose own pose is that far off, and that a capture without a subject takes
  double late_m = 0;  // centres, RMS after the first 140 frames
};

// A hand that turns on the spot, with some sway, in a room whose walls are 3 m away, before a shutter that
// rolls for 26 ms.
TurnOutcome FollowTurns(unsigned room_seed, const CameraModel& camera, const TrackerOptions& options,
                        int frames) {
  const test::TexturedRoom room({.furniture = test::Furniture::kRound, .seed = room_seed});
  Tracker tracker(camera, options);
  constexpr double kDistance_m = 3;
  std::vector<Track> tracks;
  std::vector<TimedPose> given, of_pictures, truth, late;
  for (int k = 0; k < frames; ++k) {
    const Track track =
        tracker.Step(room.TakeRolling(test::TexturedRoom::TurningAndSwayingAt, k, 0.026, camera));
    const double time_s = k / 30.0;
    truth.push_back({time_s, test::TexturedRoom::TurningAndSwayingAt(k)});
    if (!track.cam_from_world) continue;
    tracks.push_back(track);
    given.push_back({time_s, track.middle_row_from_picture.value_or(Rigid3{}) * *track.cam_from_world});
    of_pictures.push_back({time_s, *track.cam_from_world});
    if (k >= 140) late.push_back(given.back());
  }
  const auto error = CompareTrajectories(given, truth, 0.001),
             picture_error = CompareTrajectories(of_pictures, truth, 0.001),
             error_late = CompareTrajectories(late, truth, 0.001);
  if (!error || !error_late || !picture_error) return {};
  const auto is_wrong = [&](const TrajectoryError::AtTime& at) {
    return at.distance > 0.03 * kDistance_m || at.turn_deg > 2;
  };
  TurnOutcome outcome{.given = given.size(), .late_m = error_late->ate_rmse};
  for (std::size_t i = 0; i < given.size(); ++i) {
    const bool wrong = is_wrong(error->errors[i]);
    outcome.recorded_wrong +=
        is_wrong(picture_error->errors[i]) && *tracks[i].PictureSigma() <= 0.01 * tracks[i].distance;
    outcome.wrong += wrong;
    outcome.unsaid += wrong && tracks[i].quality >= 0.5;
  }
  std::printf("room %u: %zu poses, %d wrong, %d unsaid, %d pictures recorded wrong, late %.1f mm\n",
              room_seed, outcome.given, outcome.wrong, outcome.unsaid, outcome.recorded_wrong,
              1000 * outcome.late_m);
  return outcome;
}

// While the shutter is not known, which takes some seconds, poses are wrong; they must not look right.
TEST(RollingShutter, WrongPosesOnAFastTurnSaySo) {
  const CameraModel camera = test::TexturedRoom::Camera().ScaledTo(320, 240);
  const auto follow = [&](bool compensated) {
    return FollowTurns(3, camera,
                       {.deterministic = true, .features = 600, .readout = {.compensate_found = compensated}},
                       240);
  };
  const TurnOutcome plain = follow(false), compensated = follow(true);
  for (const TurnOutcome* outcome : {&plain, &compensated}) ASSERT_GT(outcome->given, 150u);
  EXPECT_GT(plain.wrong, 0.25 * static_cast<double>(plain.given)) << "else the test asks nothing";
  EXPECT_LE(plain.unsaid, 0.1 * static_cast<double>(plain.given));
  EXPECT_LE(compensated.wrong, 0.25 * static_cast<double>(compensated.given));
  EXPECT_LE(compensated.unsaid, 0.02 * static_cast<double>(compensated.given));
  EXPECT_LT(compensated.late_m, 0.5 * plain.late_m);
}

TEST(RollingShutter, ManyFastTurnsHaveFewHiddenErrors) {
  std::size_t given = 0;
  int unsaid = 0;
  for (const unsigned seed : {11u, 12u, 13u, 14u, 15u, 16u}) {
    const TurnOutcome outcome = FollowTurns(seed, test::TexturedRoom::Camera(), {.deterministic = true}, 300);
    ASSERT_GT(outcome.given, 200u) << "room " << seed;
    given += outcome.given;
    unsaid += outcome.unsaid;
    EXPECT_LE(outcome.unsaid, 0.1 * static_cast<double>(outcome.given)) << "room " << seed;
    EXPECT_LE(outcome.recorded_wrong, 0.1 * static_cast<double>(outcome.given)) << "room " << seed;
  }
  std::printf("%d of %zu wrong and unsaid\n", unsaid, given);
  EXPECT_LE(unsaid, 0.02 * static_cast<double>(given));
}

TEST(RollingShutter, CompensatedErrsAsAGlobalShutter) {
  const Outcome global = Follow(0, {.deterministic = true});
  EXPECT_FALSE(global.rolling);
  const Outcome plain = Follow(kReadout_s, {.deterministic = true, .readout = {.compensate_found = false}});
  ASSERT_TRUE(plain.rolling);
  EXPECT_NEAR(plain.rolling->readout_s, kReadout_s, 0.2 * kReadout_s);
  EXPECT_FALSE(plain.rolling->compensated);
  EXPECT_NE(plain.rolling->InWords().find("readout_ms"), std::string::npos);

  const Outcome told = Follow(kReadout_s, {.deterministic = true, .readout = {.readout_s = kReadout_s}});
  EXPECT_LT(told.error_m, 2.5 * global.error_m);
  EXPECT_LT(2 * told.error_m, plain.error_m);
  EXPECT_FALSE(told.rolling->sigma_s);
  EXPECT_FALSE(told.rolling->contradicted);
  const Outcome found = Follow(kReadout_s, {.deterministic = true});
  EXPECT_LT(found.error_m, 0.8 * plain.error_m);
  ASSERT_TRUE(found.rolling);
  EXPECT_TRUE(found.rolling->compensated);
}

TEST(RollingShutter, ReportsAContradictedReadout) {
  const auto told = [](double taken_s, double given_s) {
    return Follow(taken_s, {.deterministic = true, .readout = {.readout_s = given_s}}).rolling;
  };
  const auto as_global = told(kReadout_s, 0);
  ASSERT_TRUE(as_global && as_global->contradicted);
  EXPECT_NEAR(as_global->contradicted->readout_s, kReadout_s, 0.25 * kReadout_s);
  EXPECT_FALSE(as_global->compensated);
  EXPECT_NE(as_global->InWords().find("not the 0 ms given"), std::string::npos);
  const auto as_rolling = told(0, kReadout_s);
  ASSERT_TRUE(as_rolling && as_rolling->contradicted);
  EXPECT_NE(as_rolling->InWords().find("a global shutter, not a rolling one of 20 ms"), std::string::npos);
}

// Keyframes get their rows while a mapper has the map, too. How far it gets between frames is the machine's
// business, so that no two runs err alike: of three pairs the middle one counts, so that two that agree are
// enough. In the pauses it gets to its end.
TEST(RollingShutter, IsCompensatedWithAMapperThread) {
  int better = 0, not_better = 0;
  while (better < 2 && not_better < 2) {
    const Outcome plain = Follow(kReadout_s, {.wait_for_mapper = true, .readout = {.readout_s = 0}});
    const Outcome found = Follow(kReadout_s, {.wait_for_mapper = true}, 8);
    ASSERT_TRUE(found.rolling);
    EXPECT_TRUE(found.rolling->compensated);
    EXPECT_NEAR(found.rolling->readout_s, kReadout_s, 0.25 * kReadout_s);
    ++(found.late_error_m < 0.8 * plain.late_error_m ? better : not_better);
  }
  EXPECT_EQ(better, 2);
}

}  // namespace
}  // namespace ulf::rolling_shutter_test
