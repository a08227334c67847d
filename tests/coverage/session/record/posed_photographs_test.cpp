// Tests: coverage/session/record/posed_photographs.
//
// Captures without a subject: photographs of a walk, by parallax and overlap, the sharpest of neighbours.
#include "coverage/session/record/posed_photographs.h"

#include <gmock/gmock.h>

#include <fmt/core.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "acquisition/opening/open_device.h"
#include "acquisition/simulator/simulated_device.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/unposed_photographs.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/refine/locate_photographs.h"
#include "tracking/refine/refine.h"
#include "tracking/refine/refine_input.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test::posed_photographs_test {
namespace {
namespace fs = std::filesystem;

using ::testing::HasSubstr;

// Past the plane, looking straight at it.
Rigid3 Passing(double x, double yaw_deg = 0) { return Turned(LookAt({x, 0, 1}, {x, 0, 0}, kUp), yaw_deg); }

std::vector<PlanarShot> Walk(double from, double to, double step) {
  std::vector<PlanarShot> shots;
  const int count = static_cast<int>(std::lround(std::abs(to - from) / step));
  for (int i = 0; i <= count; ++i) shots.push_back({Passing(from + (to > from ? i : -i) * step)});
  return shots;
}

CaptureOptions WithoutSubject() {
  CaptureOptions options;
  options.without_subject = PhotographSpacing{.parallax_deg = 4};
  options.deterministic = true;
  return options;
}

struct Walked {
  CaptureSummary summary;
  LightField light_field;
};

Walked CaptureWalk(const fs::path& dir, std::vector<PlanarShot> shots, PoseSource& poses,
                   const CaptureHooks& hooks = {}) {
  PlanarDevice device(std::move(shots));
  device.Start();
  Walked walked;
  walked.summary = RunCapture(device, kCamera, poses, NewWriter(dir), WithoutSubject(), hooks);
  walked.light_field = ReadLightField(dir);
  return walked;
}

double ParallaxDeg(const Rigid3& a, const Rigid3& b) {
  return std::atan((a.OriginInSource() - b.OriginInSource()).norm()) * 180 / M_PI;  // at a distance of 1
}

TEST(PosedPhotographs, StandApartByParallaxOnAWalk) {
  const ScratchFolder scratch;
  DriftingSource poses(Rigid3{});
  const Walked walked = CaptureWalk(scratch / "lf", Walk(-0.6, 0.6, 0.01), poses);
  const std::vector<View>& views = walked.light_field.views;
  ASSERT_GT(views.size(), 10u);
  ASSERT_LT(views.size(), 25u);
  for (std::size_t i = 1; i < views.size(); ++i) {
    const double parallax = ParallaxDeg(views[i].cam_from_world, views[i - 1].cam_from_world);
    EXPECT_GT(parallax, 2) << i;
    EXPECT_LT(parallax, 7) << i;
  }
  EXPECT_FALSE(walked.light_field.subject);
  EXPECT_FALSE(walked.summary.subject);
  std::uint64_t sum = 0;
  for (const std::uint64_t count : walked.summary.reasons) sum += count;
  EXPECT_EQ(sum, walked.summary.frames) << "every frame has one reason, also those that were held";
  EXPECT_EQ(Counted(walked.summary).at("recorded"), views.size());
}

TEST(PosedPhotographs, AWayBackAddsNothingAndATurnDoes) {
  std::vector<PlanarShot> there = Walk(-0.5, 0.5, 0.02), back = Walk(0.5, -0.5, 0.02), turn = there;
  const auto count = [](const std::vector<PlanarShot>& shots) {
    const ScratchFolder scratch;
    DriftingSource poses(Rigid3{});
    return CaptureWalk(scratch / "lf", shots, poses).light_field.views.size();
  };
  const std::size_t once = count(there);
  std::vector<PlanarShot> both = there;
  both.insert(both.end(), back.begin(), back.end());
  EXPECT_LE(count(both), once + 2);
  for (int i = 0; i <= 40; ++i) turn.push_back({Passing(0.5, i)});  // most of a picture's width
  EXPECT_GE(count(turn), once + 2) << "what comes into the picture is new though nothing shifts";
}

// Every third frame is sharp.
class ShakySource : public DriftingSource {
 public:
  ShakySource() : DriftingSource(Rigid3{}) {}
  Track Step(const Frame& frame) override {
    Track track = DriftingSource::Step(frame);
    track.sharpness = frame.id % 3 == 1 ? 1.2 : 0.8;
    return track;
  }
};

TEST(PosedPhotographs, RecordTheSharpestNeighbour) {
  const ScratchFolder scratch;
  ShakySource poses;
  std::map<double, bool> sharp;
  CaptureHooks hooks;
  hooks.keep_frame = [&](const Frame& frame) { sharp[frame.device_time_s] = frame.id % 3 == 1; };
  const Walked walked = CaptureWalk(scratch / "lf", Walk(-0.6, 0.6, 0.006), poses, hooks);
  ASSERT_GT(walked.light_field.views.size(), 8u);
  std::size_t sharp_views = 0;
  for (const View& view : walked.light_field.views) sharp_views += sharp.at(view.device_time_s);
  EXPECT_EQ(sharp_views, walked.light_field.views.size());
}

// Each frame sharper than the one before it.
class SteadyingSource : public DriftingSource {
 public:
  SteadyingSource() : DriftingSource(Rigid3{}) {}
  Track Step(const Frame& frame) override {
    Track track = DriftingSource::Step(frame);
    track.sharpness = 0.8 + 0.001 * static_cast<double>(++steps_);
    return track;
  }

 private:
  int steps_ = 0;
};

TEST(PosedPhotographs, PauseRecordsTheHeldFrame) {
  const ScratchFolder scratch;
  SteadyingSource poses;
  CaptureRequests requests;
  std::optional<double> held_s, first_of_pause_s;
  std::uint64_t paused_after = 0;
  bool seen_recorded = false;
  CaptureHooks hooks;
  hooks.requests = &requests;
  hooks.after_frame = [&](const SharedCaptureState& now) {
    if (!held_s && now->decision.reason == Reason::kRecorded) {
      held_s = now->device_time_s;
      paused_after = now->frames;
      requests.Push(SetRecording{false});
    } else if (held_s && !first_of_pause_s) {
      first_of_pause_s = now->device_time_s;
      seen_recorded = now->view_ids.size() == 1;
    }
    if (held_s && now->frames == paused_after + 60) requests.Push(SetRecording{true});
  };
  const Walked walked = CaptureWalk(scratch / "lf", Walk(-0.3, 0.3, 0.004), poses, hooks);
  ASSERT_TRUE(held_s && first_of_pause_s);
  EXPECT_TRUE(seen_recorded);
  const std::vector<View>& views = walked.light_field.views;
  ASSERT_GT(views.size(), 2u) << "and goes on";
  EXPECT_EQ(views[0].device_time_s, *held_s) << "not a sharper one of the pause, and not none";
  EXPECT_GT(views[1].device_time_s, *held_s + 59 / 15.0) << "none of the pause";
  EXPECT_GT(Counted(walked.summary).at("paused"), 10u);
  std::uint64_t sum = 0;
  for (const std::uint64_t count : walked.summary.reasons) sum += count;
  EXPECT_EQ(sum, walked.summary.frames);
}

TEST(PosedPhotographs, WaitingFrameKeepsItsDepth) {
  constexpr double kDepth = 7;
  Frame frame;
  frame.image.pixels = cv::Mat(kCamera.height, kCamera.width, CV_8U, cv::Scalar(128));
  std::vector<VisiblePoint> points;
  for (int i = -5; i <= 5; ++i)
    for (int j = -4; j <= 4; ++j) {
      const Vector3d in_cam(0.4 * i, 0.4 * j, kDepth);
      points.push_back({in_cam, *kCamera.ImgFromCam(in_cam), kDepth});
    }
  Track track;
  track.state = TrackState::kTracking;
  track.cam_from_world = Rigid3{};
  track.quality = 1;
  PosedPhotographs walk({});
  const RecordedViews none{LightField{}};
  const FrameToDecide input{.frame = frame, .track = track, .camera = kCamera};
  const PosedPhotographs::Step step = walk.Decide(input, points, none);
  ASSERT_EQ(step.decision.reason, Reason::kRecorded);
  EXPECT_FALSE(walk.Take(step, input)) << "its neighbours are still to come";
  const Track lost;
  const FrameToDecide next{.frame = frame, .track = lost, .camera = kCamera};
  const auto recorded = walk.Take(walk.Decide(next, {}, none), next);
  ASSERT_TRUE(recorded);
  EXPECT_EQ(recorded->depth, kDepth);
}

TEST(PosedPhotographs, AnswerSubjectRequestsInWords) {
  const ScratchFolder scratch;
  DriftingSource poses(Rigid3{});
  CaptureRequests requests;
  std::vector<std::string> said;
  bool without_subject = false;
  CaptureHooks hooks;
  hooks.requests = &requests;
  hooks.say = [&](const std::string& line) { said.push_back(line); };
  hooks.after_frame = [&](const SharedCaptureState& now) {
    if (now->frames == 20) requests.Push(FindSubject{});
    if (now->frames == 40) requests.Push(TakeBackLast{});
    without_subject = now->without_subject;
  };
  const Walked walked = CaptureWalk(scratch / "lf", Walk(-0.5, 0.5, 0.01), poses, hooks);
  EXPECT_TRUE(without_subject);
  EXPECT_THAT(said, ::testing::Contains(HasSubstr("no subject to place")));
  EXPECT_EQ(walked.summary.taken_back, 1u);
  EXPECT_THAT(said, ::testing::Contains(
                        ::testing::MatchesRegex("taken back, kept in unposed/: 1 view \\([0-9]+\\)")));
}

// A hand that goes past the studio, looking straight on.
class PassingHand : public HandMotion {
 public:
  Rigid3 CamFromWorld(double time_s) const override {
    const Vector3d at(-0.5 + 0.2 * time_s, -1.1, 0.35 + 0.02 * std::sin(time_s));
    return LookAt(at, at + Vector3d(0, 1, -0.25), Vector3d::UnitZ());
  }
};

TEST(PosedPhotographs, CaptureATrackedWalk) {
  const ScratchFolder scratch;
  const auto device = OpenSimulatedDevice(DeviceUri::Parse("sim:studio?width=256&height=192&duration_s=7"),
                                          std::make_shared<PassingHand>());
  device->Start();
  const CameraModel camera = *device->Camera();
  const auto poses = MakeTrackerSource(camera, {.deterministic = true, .wait_for_mapper = true});
  CaptureOptions options = WithoutSubject();
  options.max_frames = 50;
  const CaptureSummary summary =
      RunCapture(*device, camera, *poses, NewWriter(scratch / "lf", camera), options);
  const LightField light_field = ReadLightField(scratch / "lf");
  EXPECT_GE(light_field.views.size(), 3u);
  EXPECT_LE(light_field.views.size(), 40u);
  EXPECT_GT(light_field.points.size(), 100u);
  EXPECT_FALSE(light_field.subject);
  EXPECT_EQ(Counted(summary).count("outside_rectangle"), 0u);
}

// A hand that stands before the studio and turns to and fro.
class TurningHand : public HandMotion {
 public:
  Rigid3 CamFromWorld(double time_s) const override {
    const Vector3d at(0, -1.1, 0.35);
    return LookAt(at, at + Vector3d(0.3 * std::sin(time_s), 1, -0.25), Vector3d::UnitZ());
  }
};

TEST(PosedPhotographs, CountTurnsWithoutTranslation) {
  const ScratchFolder scratch;
  const auto device = OpenSimulatedDevice(DeviceUri::Parse("sim:studio?width=256&height=192&duration_s=4"),
                                          std::make_shared<TurningHand>());
  device->Start();
  const CameraModel camera = *device->Camera();
  const auto poses = MakeTrackerSource(camera, {.deterministic = true, .wait_for_mapper = true});
  const CaptureSummary summary =
      RunCapture(*device, camera, *poses, NewWriter(scratch / "lf", camera), WithoutSubject());
  EXPECT_EQ(summary.recorded, 0u);
  ASSERT_TRUE(summary.start_obstacles.contains(StartObstacle::kRotationOnly));
  EXPECT_GT(summary.start_obstacles.at(StartObstacle::kRotationOnly), summary.frames / 2);
}

// The camera is carried to another side of a room, without seeing the way, and walks on to where it
// began. Until then nobody knows how the two sides lie to each other: what is recorded before and after
// is in one world.
TEST(PosedPhotographs, RecordNothingInAnUnjoinedPart) {
  const ScratchFolder scratch;
  const TexturedRoom room({.furniture = Furniture::kRound});
  const CameraModel camera = TexturedRoom::Camera().ScaledTo(320, 240);
  std::vector<Rigid3> truth;
  const auto show = [&](int from, int to) {
    for (int k = from; k < to; ++k) {
      truth.push_back(TexturedRoom::RoundAt(k));
      const Frame frame = room.Take(truth.back(), truth.size(), camera);
      cv::imwrite((scratch / "frames" / fmt::format("{:04}.png", truth.size())).string(), frame.image.pixels);
    }
  };
  fs::create_directories(scratch / "frames");
  show(0, 110);
  show(190, 400);
  const auto device = OpenDevice("replay:" + (scratch / "frames").string() + "?fps=30");
  device->Start();
  const auto poses =
      MakeTrackerSource(camera, {.deterministic = true, .features = 500, .wait_for_mapper = true});
  std::vector<double> apart_s;
  CaptureHooks hooks;
  hooks.after_frame = [&](const SharedCaptureState& state) {
    if (state->tracking == TrackState::kApart) apart_s.push_back(state->device_time_s);
    EXPECT_TRUE(state->tracking != TrackState::kApart || !state->cam_from_world);
  };
  CaptureOptions options = WithoutSubject();
  options.keep_apart = true;
  const CaptureSummary summary =
      RunCapture(*device, camera, *poses, NewWriter(scratch / "lf", camera), options, hooks);
  const LightField light_field = ReadLightField(scratch / "lf");
  ASSERT_GE(apart_s.size(), 40u);
  std::vector<TimedPose> recorded, all;
  int before = 0, after = 0;
  for (const View& view : light_field.views) {
    before += view.device_time_s < apart_s.front();
    after += view.device_time_s > apart_s.back();
    recorded.push_back({view.device_time_s, view.cam_from_world});
  }
  EXPECT_GE(before, 3);
  EXPECT_GE(after, 3);
  EXPECT_EQ(before + after, static_cast<int>(light_field.views.size()));
  for (std::size_t i = 0; i < truth.size(); ++i) all.push_back({static_cast<double>(i) / 30, truth[i]});
  EXPECT_LT(CompareTrajectories(recorded, all, 0.005)->ate_rmse, 0.02);
  // What it saw apart is kept without a pose, and its place is found from the views on both sides.
  const std::vector<UnposedPhotograph> kept = UnposedPhotographs(light_field);
  EXPECT_EQ(kept.size(), summary.kept_apart);
  EXPECT_GE(kept.size(), 3u);
  EXPECT_LE(kept.size(), apart_s.size() / 2);
  LightField with_kept = light_field;
  for (const UnposedPhotograph& photograph : kept) {
    EXPECT_GE(photograph.view.device_time_s, apart_s.front());
    EXPECT_LE(photograph.view.device_time_s, apart_s.back());
    with_kept.views.push_back(photograph.view);
  }
  const auto located =
      tracking::LocatePhotographs(tracking::RefineInputOf(with_kept), light_field.views.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    ASSERT_TRUE(located[i].cam_from_world) << kept[i].view.image_path << ": " << located[i].why;
    with_kept.views[light_field.views.size() + i].cam_from_world = *located[i].cam_from_world;
  }
  const tracking::RefineResult refined =
      tracking::Refine(tracking::RefineInputOf(with_kept), {.features = 800});
  recorded.clear();
  for (std::size_t v = 0; v < with_kept.views.size(); ++v)
    recorded.push_back({with_kept.views[v].device_time_s, refined.views[v].cam_from_world});
  EXPECT_EQ(refined.registered, static_cast<int>(with_kept.views.size()));
  EXPECT_LT(CompareTrajectories(recorded, all, 0.005)->ate_rmse, 0.01);
}

// The zoom is moved on the way and put back: what is taken meanwhile is no picture of the light field's lens.
TEST(PosedPhotographs, RecordNothingDuringAZoom) {
  const ScratchFolder scratch;
  const TexturedRoom room({.seed = 11});
  const CameraModel camera = TexturedRoom::Camera().ScaledTo(320, 240);
  fs::create_directories(scratch / "frames");
  constexpr int kFrom = 50, kBack = 85, kFrames = 125;
  for (int k = 0; k < kFrames; ++k) {
    CameraModel taken = camera;
    if (k >= kFrom && k < kBack) taken.fx *= 1.1, taken.fy *= 1.1;
    const Frame frame = room.Take(TexturedRoom::HandAt(2 * k), static_cast<std::uint64_t>(k), taken);
    cv::imwrite((scratch / "frames" / fmt::format("{:04}.png", k)).string(), frame.image.pixels);
  }
  const auto device = OpenDevice("replay:" + (scratch / "frames").string() + "?fps=30");
  device->Start();
  const auto poses =
      MakeTrackerSource(camera, {.deterministic = true, .features = 500, .wait_for_mapper = true});
  std::vector<std::string> said;
  CaptureHooks hooks;
  hooks.say = [&](const std::string& line) { said.push_back(line); };
  const CaptureSummary summary =
      RunCapture(*device, camera, *poses, NewWriter(scratch / "lf", camera), WithoutSubject(), hooks);
  EXPECT_THAT(said, ::testing::Contains(::testing::HasSubstr(
                        "the zoom was moved, or another lens is mounted: the focal length is")));
  EXPECT_THAT(said, ::testing::Contains("the zoom is back"));
  const auto reasons = Counted(summary);
  ASSERT_TRUE(reasons.contains("zoomed"));
  EXPECT_GE(reasons.at("zoomed"), 25u);
  EXPECT_LE(reasons.at("zoomed"), 40u);
  const LightField light_field = ReadLightField(scratch / "lf");
  EXPECT_GE(light_field.views.size(), 5u);
  for (const View& view : light_field.views) {
    const int frame = static_cast<int>(std::lround(30 * view.device_time_s));
    EXPECT_TRUE(frame < kFrom || frame >= kBack) << "frame " << frame << " was recorded";
  }
}

// ---- the commands on it

// Photographs of a walk past a wall: axes that meet nowhere.
void WriteWalk(const fs::path& dir) {
  CaptureHeader header;
  header.camera = kCamera;
  LightFieldWriter writer = LightFieldWriter::Create(dir, header);
  PlanarDevice device(Walk(-0.4, 0.4, 0.1));
  device.Start();
  while (const auto frame = device.Next(std::chrono::milliseconds(0))) {
    View view;
    view.cam_from_world = *frame->known_cam_from_world;
    writer.AddView(*frame, view);
  }
  writer.Close(3);
}

TEST(WithoutASubject, CommandsSayWhatIsThereOrAskForOne) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "walk").string(), picture = (scratch / "p.png").string();
  WriteWalk(dir);
  const CommandResult info = RunUlf("info " + dir);
  EXPECT_EQ(info.exit_code, 0) << info.errors;
  EXPECT_THAT(info.output, HasSubstr("views          9\n"));
  EXPECT_THAT(info.output, HasSubstr("subject        none"));
  EXPECT_EQ(RunUlf("info " + dir + " --json").exit_code, 0);
  const CommandResult cap = RunUlf("info " + dir + " --cap 60x40");
  EXPECT_EQ(cap.exit_code, 2);
  EXPECT_THAT(cap.errors, HasSubstr("--subject x,y,z,radius"));
  for (const std::string& command :
       {"render " + dir + " --width 64 --height 48 -o " + picture, "evaluate " + dir + " --fields nearest",
        "sheet " + dir + " -o " + picture}) {
    const CommandResult without = RunUlf(command);
    EXPECT_EQ(without.exit_code, 2) << command;
    EXPECT_THAT(without.errors, HasSubstr("--subject x,y,z,radius")) << command;
    const CommandResult with = RunUlf(command + " --subject 0,0,0,0.2");
    EXPECT_EQ(with.exit_code, 0) << command << ": " << with.errors;
  }
  const std::string import_it = "import " + dir + " -o " + (scratch / "copy").string();
  const CommandResult import = RunUlf(import_it);
  EXPECT_EQ(import.exit_code, 0) << import.errors;
  EXPECT_EQ(ReadLightField(scratch / "copy").views.size(), 9u);
}

TEST(WithoutASubject, RefusesCommandsThatNeedOne) {
  const ScratchFolder scratch;
  const std::string capture = "capture --no-geometry sim:studio --headless --no-subject -o " +
                              (scratch / "lf").string() + " --frames 2 ";
  for (const char* with :
       {"--until-covered 60x40", "--subject 0,0,1,0.1", "--subject-size 0.2", "--quality fast",
        "--threshold-px 9", "--operator novice", "--overlay a.png", "--map a.png", "--poses known"}) {
    const CommandResult result = RunUlf(capture + with);
    EXPECT_EQ(result.exit_code, 2) << with;
    EXPECT_THAT(result.errors, HasSubstr(std::string(with).substr(0, std::string(with).find(' '))));
    EXPECT_THAT(result.errors, HasSubstr("--no-subject"));
  }
  const CommandResult spacing = RunUlf("capture --no-geometry sim:studio --headless -o " +
                                       (scratch / "lf").string() + " --frames 2 --parallax-deg 3");
  EXPECT_EQ(spacing.exit_code, 2);
  EXPECT_THAT(spacing.errors, HasSubstr("--no-subject"));
  EXPECT_FALSE(fs::exists(scratch / "lf"));
}

}  // namespace
}  // namespace ulf::test::posed_photographs_test
