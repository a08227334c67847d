// Tests: coverage/session/record/capture_lens, coverage/session/running_capture,
// coverage/session/subject_anchors, coverage/session/preflight, coverage/session/record/capture_record.
//
// A capture whose lens is replaced while it records: everything that was recorded follows.
#include "coverage/session/record/capture_lens.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>

#include "acquisition/calibration/intrinsics.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/folder/light_field_io.h"
#include "coverage/session/subject_anchors.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test::capture_lens_test {
namespace {
namespace fs = std::filesystem;

using Eigen::Vector2d;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

CameraModel WithFocal(double factor, CameraModel camera) {
  camera.fx *= factor;
  camera.fy *= factor;
  return camera;
}

// ---- An imagined tracker ----

// Its cameras look straight at the plane z = 0, and under a lens that is too long they stand too far from it
// by the same share, as in any map of parallax.

constexpr double kTooLong = 1.05;

std::vector<PlanarShot> StraightAt(int shots, double distance = 1) {
  std::vector<PlanarShot> straight;
  for (int i = 0; i < shots; ++i) {
    const Vector3d at(0.03 * (i % 8) - 0.1, 0.04 * (i / 8) - 0.05, distance);
    straight.push_back({LookAt(at, at - Vector3d::UnitZ(), kUp)});
  }
  return straight;
}

class LensSource : public PoseSource {
 public:
  // Replaces the lens in this frame, counted from 0, or contradicts it from then on.
  LensSource(int frame, tracking::LensUse use) : frame_(frame), use_(use) {}
  Track Step(const Frame& frame) override {
    const int number = static_cast<int>(frame_of_.size());
    frame_of_.push_back(*frame.known_cam_from_world);
    const bool knows = frame_ >= 0 && number >= frame_;
    replaced_ |= knows && use_ == tracking::LensUse::kRefine;
    Track track;
    track.state = TrackState::kTracking;
    track.wrong_lens = knows && use_ == tracking::LensUse::kCheck;
    track.lens_revision = replaced_;
    track.map_revision = replaced_;
    track.anchor = Anchored{number, Rigid3{}};
    track.cam_from_world = PoseOf(*track.anchor);
    track.quality = 1;
    return track;
  }
  std::optional<Track> Locate(const Frame&, const CameraModel&, const std::optional<Rigid3>&) const override {
    return std::nullopt;
  }
  Rigid3 PoseOf(const Anchored& anchor) const override {
    const Rigid3& truth = frame_of_.at(static_cast<std::size_t>(anchor.keyframe_id));
    Vector3d at = truth.OriginInSource();
    if (!replaced_) at.z() *= kTooLong;
    return anchor.cam_from_keyframe * Rigid3{truth.rotation, -(truth.rotation * at)};
  }
  void Finish() override { replaced_ |= frame_ < 0; }
  tracking::TrackerStatistics Statistics() const override {
    tracking::TrackerStatistics known;
    if (replaced_) known.refined_lens = tracking::RefinedLens{kCamera, 0.4};
    if (use_ == tracking::LensUse::kCheck)
      known.calibration = tracking::CalibrationCheck{.given_focal_px = kTooLong * kCamera.fx,
                                                     .fitted_focal_px = kCamera.fx,
                                                     .sigma_px = 0.4,
                                                     .determined = true,
                                                     .focal_wrong = true};
    return known;
  }

 private:
  const int frame_;
  const tracking::LensUse use_;
  bool replaced_ = false;
  std::vector<Rigid3> frame_of_;  // true poses
};

struct Imagined {
  fs::path dir;
  int frame = 20;  // in which the lens is known; -1: at the end
  tracking::LensUse use = tracking::LensUse::kRefine;
  CaptureOptions options = Options();
  std::vector<std::string> said = {};
  std::vector<SharedCaptureState> states = {};
  CaptureSummary summary = {};

  LightField Run() {
    PlanarDevice device(StraightAt(40));
    device.Start();
    LensSource poses(frame, use);
    options.lens = use;
    const CameraModel given = WithFocal(kTooLong, kCamera);
    CaptureHooks hooks;
    hooks.say = [&](const std::string& line) { said.push_back(line); };
    hooks.after_frame = [&](const SharedCaptureState& state) { states.push_back(state); };
    summary = RunCapture(device, given, poses, NewWriter(dir, given), options, hooks);
    return ReadLightField(dir);
  }
};

void ExpectTruePoses(const LightField& light_field) {
  const std::vector<PlanarShot> truth = StraightAt(40);
  ASSERT_GT(light_field.views.size(), 8u);
  for (const View& view : light_field.views) {
    const auto shot = static_cast<std::size_t>(std::lround(view.device_time_s * 15));
    EXPECT_LT((view.CenterInWorld() - truth.at(shot).cam_from_world.OriginInSource()).norm(), 1e-9)
        << "view " << view.id;
  }
}

TEST(CaptureLens, ViewsSubjectAndMapFollowTheFoundLens) {
  const ScratchFolder scratch;
  Imagined capture{scratch / "lf"};
  capture.options.cap = Cap::ParseDegrees("16x12");
  const LightField light_field = capture.Run();
  EXPECT_EQ(light_field.cameras.at(0), kCamera);
  ExpectTruePoses(light_field);
  ASSERT_TRUE(capture.summary.refined_lens);
  EXPECT_EQ(capture.summary.refined_lens->camera, kCamera);

  // The sphere stays on the plane and keeps its size, although all cameras came nearer.
  ASSERT_TRUE(light_field.subject);
  EXPECT_LT(light_field.subject->center_in_world.norm(), 1e-6);
  EXPECT_NEAR(light_field.subject->radius, kSubject.radius, 1e-6);

  const CaptureState &before = *capture.states.at(19), &after = *capture.states.at(20);
  EXPECT_EQ(before.camera, WithFocal(kTooLong, kCamera));
  EXPECT_EQ(after.camera, kCamera);
  EXPECT_EQ(after.recorded_camera, kCamera);
  // Nothing of the old lens is left in the map.
  const CaptureState& last = *capture.states.back();
  std::vector<CriterionView> views;
  for (const View& view : light_field.views)
    views.push_back(CriterionView::From(kCamera, view.cam_from_world, 640));
  for (const CriterionView& view : last.coverage->views()) {
    EXPECT_EQ(view.fx, views[0].fx);
    EXPECT_NEAR(view.center_in_world.z(), 1, 1e-9);
  }
  const CoverageMap anew(*last.subject, last.coverage->options(), views);
  EXPECT_NEAR(*last.covered, anew.CoveredShare(), 0.002);
  EXPECT_THAT(
      capture.said,
      Contains(AllOf(HasSubstr("images fit a focal length of 300.0 px (± 0.4), not the 315.0 px in use"),
                     HasSubstr("views so far go with it"), HasSubstr("before it was"))));
}

TEST(CaptureLens, SphereThatDidNotFollowWouldLieDeeper) {
  std::vector<PlanarShot> shots = StraightAt(8);
  PlanarDevice device(shots);
  device.Start();
  LensSource poses(8, tracking::LensUse::kRefine);
  SubjectAnchors all, one, rigid;
  for (int i = 0; i < 8; ++i) {
    const Track track = poses.Step(*device.Next({}));
    all.Add(kSubject, track);
    rigid.Add(kSubject, track);
    if (i == 0) one.Add(kSubject, track);
  }
  PlanarDevice ninth({shots[0]});
  ninth.Start();
  poses.Step(*ninth.Next({}));
  EXPECT_GT((rigid.Now(poses)->center_in_world - kSubject.center_in_world).norm(), 0.3 * kSubject.radius);
  for (SubjectAnchors* anchors : {&all, &one}) {  // one camera alone goes by the focal length
    const auto found = anchors->ReplaceLens(kCamera, WithFocal(kTooLong, kCamera), poses);
    ASSERT_TRUE(found);
    EXPECT_LT((found->center_in_world - kSubject.center_in_world).norm(), 1e-3 * kSubject.radius);
    EXPECT_NEAR(found->radius, kSubject.radius, 1e-3 * kSubject.radius);
    EXPECT_LT((anchors->Now(poses)->center_in_world - found->center_in_world).norm(), 1e-9)
        << "it holds there";
    EXPECT_NEAR(anchors->Now(poses)->radius, found->radius, 1e-9);
  }
}

TEST(CaptureLens, CutJournalHasTheOldLensOrTheNew) {
  const ScratchFolder scratch;
  Imagined capture{scratch / "lf"};
  capture.Run();
  const std::string journal = ReadWholeFile(scratch / "lf/journal.jsonl");
  const std::size_t at = journal.find("\"cameras\":{\"0\"");
  ASSERT_NE(at, std::string::npos);
  EXPECT_EQ(journal.find("\"cameras\":{\"0\"", at + 1), std::string::npos) << "one line for one lens";
  const std::size_t begin = journal.rfind('\n', at) + 1, end = journal.find('\n', at);
  const auto cut = [&](std::size_t bytes) {
    std::ofstream(scratch / "cut.jsonl") << journal.substr(0, bytes);
    return ReadJournal(scratch / "cut.jsonl").light_field;
  };
  const double old_focal = kTooLong * kCamera.fx;
  for (const std::size_t bytes : {begin, begin + 1, at, (at + end) / 2, end - 1}) {
    const LightField old = cut(bytes);
    EXPECT_DOUBLE_EQ(old.cameras.at(0).fx, old_focal) << bytes;
    EXPECT_THAT(old.CalibrationSource(0), Not(HasSubstr(acquisition::kLensFoundInCapture))) << bytes;
    ASSERT_GT(old.views.size(), 4u);
    for (const View& view : old.views) EXPECT_NEAR(view.CenterInWorld().z(), kTooLong, 1e-9);
  }
  const LightField now = cut(end + 1);
  EXPECT_EQ(now.cameras.at(0), kCamera);
  EXPECT_EQ(now.CalibrationSource(0), "the images of the capture (± 0.4 px)");
  for (const View& view : now.views) EXPECT_NEAR(view.CenterInWorld().z(), 1, 1e-9);
}

TEST(CaptureLens, LensFoundAtTheEndIsWrittenWithPoses) {
  const ScratchFolder scratch;
  Imagined capture{scratch / "lf", -1};
  const LightField light_field = capture.Run();
  EXPECT_EQ(light_field.cameras.at(0), kCamera);
  EXPECT_THAT(light_field.CalibrationSource(0), HasSubstr(acquisition::kLensFoundInCapture));
  ExpectTruePoses(light_field);
  EXPECT_LT(light_field.subject->center_in_world.norm(), 1e-6);
  EXPECT_THAT(capture.said, Contains(HasSubstr("the capture ends under this lens")));
  EXPECT_EQ(capture.summary.map->views().front().fx, CriterionView::From(kCamera, {}, 640).fx);
}

TEST(CaptureLens, WrongLensIsAMistakeOnceItShows) {
  const ScratchFolder scratch;
  const auto mistakes = [&](const char* name, int frame, tracking::LensUse use) {
    Imagined capture{scratch / name, frame, use};
    capture.Run();
    return capture.summary.mistakes;
  };
  constexpr int kNever = 1000;
  const auto early = mistakes("early", 20, tracking::LensUse::kCheck),
             late = mistakes("late", kNever, tracking::LensUse::kCheck);
  ASSERT_EQ(early.size(), 1u);
  ASSERT_EQ(late.size(), 1u);
  EXPECT_EQ(early[0].mistake, Mistake::kWrongLens);
  EXPECT_EQ(late[0].mistake, Mistake::kWrongLens);
  EXPECT_NEAR(early[0].first_s, 20 / 15.0, 1e-6);
  EXPECT_NEAR(late[0].first_s, 39 / 15.0, 1e-6);
  EXPECT_THAT(late[0].finding, HasSubstr("300.0 px"));
  EXPECT_THAT(late[0].cure, HasSubstr("intrinsics refine"));
  EXPECT_TRUE(mistakes("replaced", 20, tracking::LensUse::kRefine).empty()) << "the cure was taken";
}

TEST(CaptureLens, PreflightSaysWhatIsKnownOfTheLens) {
  const auto calibration = [](Imagined& capture, std::size_t frame) {
    const auto& items = capture.states.at(frame)->preflight;
    return *std::ranges::find(items, std::string("calibration"), &PreflightItem::name);
  };
  const ScratchFolder scratch;
  Imagined checked{scratch / "checked", 20, tracking::LensUse::kCheck};
  checked.options.begins_on_request = true;
  checked.options.calibrated = true;
  checked.options.calibration_source = "the device";
  checked.Run();
  EXPECT_EQ(calibration(checked, 19).in_order, true);
  EXPECT_EQ(calibration(checked, 20).in_order, false);
  EXPECT_FALSE(calibration(checked, 20).holds_start) << "it can be found afterwards";
  EXPECT_THAT(calibration(checked, 20).words,
              AllOf(HasSubstr("contradicted: images fit a focal length of 300.0 px"),
                    HasSubstr("or less, 4.8 % below the 315.0 given"), HasSubstr("intrinsics refine")));
  EXPECT_EQ(std::ranges::count_if(
                checked.said, [](const std::string& line) { return line.find("315.0 given") != line.npos; }),
            1)
      << "said once";

  Imagined sought{scratch / "sought"};
  sought.options.begins_on_request = true;
  sought.options.calibrated = false;
  sought.options.calibration_source = "focal length guessed";
  const LightField empty = sought.Run();
  EXPECT_EQ(calibration(sought, 19).in_order, false);
  EXPECT_THAT(calibration(sought, 19).words, AllOf(HasSubstr("guessed"), HasSubstr("is found while")));
  EXPECT_EQ(calibration(sought, 20).in_order, true);
  EXPECT_THAT(calibration(sought, 20).words, HasSubstr("found from the images: a focal length of 300.0 px"));
  EXPECT_TRUE(empty.views.empty());
  EXPECT_EQ(empty.cameras.at(0), kCamera);
  EXPECT_THAT(sought.said, Contains(HasSubstr("nothing was recorded yet")));
}

// ---- The tracker itself, in a drawn room.

class RoomDevice : public Device {
 public:
  RoomDevice(const CameraModel& camera, int frames, double readout_s = 0)
      : camera_(camera), frames_(frames), readout_s_(readout_s) {}
  DeviceInfo Info() const override { return {}; }
  std::optional<CameraModel> Camera() const override { return std::nullopt; }
  bool IsLive() const override { return false; }
  void Start() override {}
  void Stop() override {}
  DeviceState State() const override {
    return next_ < frames_ ? DeviceState::kStreaming : DeviceState::kEnded;
  }
  DeviceStatistics Statistics() const override { return {}; }
  std::optional<Frame> Next(std::chrono::milliseconds) override {
    if (next_ >= frames_) return std::nullopt;
    const int i = next_++;
    if (readout_s_ == 0) return room_.Take(HandAt(i), static_cast<std::uint64_t>(i), camera_);
    return room_.TakeRolling([](double at) { return TexturedRoom::TurningAndSwayingAt(at); }, i, readout_s_,
                             camera_);
  }
  static Rigid3 HandAt(int i) { return TexturedRoom::HandAt(3 * i); }

 private:
  const CameraModel camera_;
  const int frames_;
  const double readout_s_;
  const TexturedRoom room_{{.seed = 15}};
  int next_ = 0;
};

struct InRoom {
  CaptureSummary summary;
  LightField light_field;
  std::vector<SharedCaptureState> states;
  std::vector<std::string> said;
};

struct RoomOptions {
  CameraModel camera = TexturedRoom::Camera();
  double given_focal = 1;  // of the true one
  tracking::LensUse use = tracking::LensUse::kRefine;
  int max_side_px = 960;
  bool deterministic = true;
  double readout_s = 0;
  int frames = 100;
};

InRoom CaptureRoom(const fs::path& dir, const RoomOptions& room) {
  RoomDevice device(room.camera, room.frames, room.readout_s);
  const CameraModel given = WithFocal(room.given_focal, room.camera);
  const auto poses = MakeTrackerSource(given, {.deterministic = room.deterministic,
                                               .seed = 15,
                                               .max_side_px = room.max_side_px,
                                               .wait_for_mapper = true,
                                               .lens = room.use});
  CaptureOptions options;
  options.deterministic = room.deterministic;
  options.lens = room.use;
  InRoom result;
  CaptureHooks hooks;
  hooks.after_frame = [&](const SharedCaptureState& state) { result.states.push_back(state); };
  hooks.say = [&](const std::string& line) { result.said.push_back(line); };
  result.summary = RunCapture(device, given, *poses, NewWriter(dir, given), options, hooks);
  result.light_field = ReadLightField(dir);
  return result;
}

double ErrorOf(const LightField& light_field) {
  std::vector<TimedPose> found, truth;
  for (const View& view : light_field.views) {
    found.push_back({view.device_time_s, view.cam_from_world});
    truth.push_back(
        {view.device_time_s, RoomDevice::HandAt(static_cast<int>(std::lround(30 * view.device_time_s)))});
  }
  return CompareTrajectories(found, truth, 1e-6).value().ate_rmse;
}

// The sphere's middle and width in the picture, in pixels.
std::pair<Vector2d, double> InPicture(const CaptureState& state) {
  const Vector3d center = *state.cam_from_world * state.subject->center_in_world;
  const Vector2d middle = *state.camera.ImgFromCam(center);
  const Vector2d rim = *state.camera.ImgFromCam(center + state.subject->radius * Vector3d::UnitX());
  return {middle, 2 * (rim - middle).norm()};
}

TEST(CaptureLens, WrongFocalLengthIsFoundWhileRecording) {
  const ScratchFolder scratch;
  RoomOptions room;
  // Tracked at a smaller size than it is recorded.
  room.given_focal = 1.05;
  room.max_side_px = 480;
  room.frames = 80;
  const InRoom refined = CaptureRoom(scratch / "refined", room);
  ASSERT_TRUE(refined.summary.refined_lens);
  const CameraModel& lens = refined.light_field.cameras.at(0);
  EXPECT_EQ(lens, refined.summary.refined_lens->camera);
  EXPECT_EQ(lens.width, room.camera.width);
  EXPECT_NEAR(lens.fx, room.camera.fx, 0.005 * room.camera.fx);
  room.use = tracking::LensUse::kFixed;
  const InRoom fixed = CaptureRoom(scratch / "fixed", room);
  ASSERT_GT(refined.light_field.views.size(), 5u);
  EXPECT_LT(ErrorOf(refined.light_field), 0.5 * ErrorOf(fixed.light_field));

  // In the frame in which the lens changes the sphere stays what it is in the pictures.
  const auto first_under = std::ranges::find_if(
      refined.states, [](const auto& state) { return state->camera.fx < 1.04 * TexturedRoom::Camera().fx; });
  ASSERT_NE(first_under, refined.states.end());
  ASSERT_GT(first_under - refined.states.begin(), 10);
  ASSERT_TRUE((*std::prev(first_under))->subject) << "there was one before";
  const auto [before, width_before] = InPicture(**std::prev(first_under));
  const auto [after, width_after] = InPicture(**first_under);
  const auto [earlier, width_earlier] = InPicture(**std::prev(first_under, 2));
  const double moves_px = (before - earlier).norm();  // from frame to frame
  EXPECT_LT((after - before).norm(), moves_px + 8);
  EXPECT_NEAR(width_after / width_before, 1, 0.03);
}

TEST(CaptureLens, RightLensStaysAndIsNotRewritten) {
  const ScratchFolder scratch;
  const auto journal = [&](tracking::LensUse use, const char* name) {
    const InRoom room = CaptureRoom(scratch / name, {.use = use, .max_side_px = 480, .frames = 60});
    EXPECT_FALSE(room.summary.refined_lens);
    EXPECT_GT(room.light_field.views.size(), 5u);
    return ReadWholeFile(scratch / name / "journal.jsonl");
  };
  EXPECT_TRUE(journal(tracking::LensUse::kRefine, "refine") == journal(tracking::LensUse::kCheck, "check"));
}

TEST(CaptureLens, EndsWithThreadsAndARollingShutter) {
  const ScratchFolder scratch;
  const InRoom room = CaptureRoom(
      scratch / "lf", {.given_focal = 1.08, .deterministic = false, .readout_s = 0.02, .frames = 160});
  ASSERT_TRUE(room.summary.refined_lens);
  EXPECT_TRUE(room.summary.rolling_shutter);
  EXPECT_NEAR(room.light_field.cameras.at(0).fx, 520, 0.02 * 520);
  EXPECT_EQ(room.light_field.cameras.at(0), room.summary.refined_lens->camera);
}

}  // namespace
}  // namespace ulf::test::capture_lens_test
