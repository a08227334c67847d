// Tests: coverage/session/capture_session, coverage/session/record/capture_recorder,
// coverage/bound/sphere_outline, coverage/session/capture_summary, coverage/session/record/capture_options.
#include "coverage/session/capture_session.h"
#include "coverage/bound/criterion.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <fstream>
#include <map>

#include "commands/reports/light_field_report.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "coverage/bound/sphere_outline.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/floors.h"
#include "tests/support/planar_device.h"
#include "tests/support/test_paths.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test::capture_session_test {
namespace {
namespace fs = std::filesystem;

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Lt;

// A device whose driver throws in the middle of a capture.
class BreakingDevice : public PlanarDevice {
 public:
  using PlanarDevice::PlanarDevice;
  std::optional<Frame> Next(std::chrono::milliseconds timeout) override {
    if (++asked_ > 4) throw Error("planar: the driver broke; connect it again");
    return PlanarDevice::Next(timeout);
  }

 private:
  int asked_ = 0;
};

TEST(CaptureSession, ThrowingDriverClosesTheLightField) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  BreakingDevice device(Sweep(40, 20, 5));
  const auto poses = MakeKnownPoseSource(kCamera, kSubject);
  device.Start();
  EXPECT_THAT([&] { RunCapture(device, kCamera, *poses, NewWriter(dir), Options()); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("the driver broke")));
  const LightField kept = ReadLightField(dir);
  EXPECT_EQ(kept.views.size(), 4u) << "what came before is kept";
  EXPECT_EQ(kept.reasons.at("recorded"), 4u) << "and closed in good order";
  EXPECT_TRUE(fs::exists(dir / "transforms.json"));
}

// A camera that says nothing for three seconds and goes on by itself.
class PausingDevice : public PlanarDevice {
 public:
  using PlanarDevice::PlanarDevice;
  bool IsLive() const override { return true; }
  std::optional<Frame> Next(std::chrono::milliseconds timeout) override {
    auto frame = PlanarDevice::Next(timeout);
    if (frame && frame->id >= 10) frame->device_time_s += 3;
    return frame;
  }
};

TEST(CaptureSession, SecondsWithoutFramesAreAGap) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  PausingDevice device(Sweep(60, 20, 5));
  const auto poses = MakeKnownPoseSource(kCamera, kSubject);
  device.Start();
  RunCapture(device, kCamera, *poses, NewWriter(dir), Options());
  const std::string journal = ReadWholeFile(dir / "journal.jsonl");
  const std::size_t gap = journal.find("device: no frames");
  ASSERT_NE(gap, std::string::npos) << journal;
  EXPECT_EQ(journal.find("device: no frames", gap + 1), std::string::npos) << "one gap, one line";
}

TEST(CaptureSession, EveryFrameHasItsReason) {
  const ScratchFolder scratch;
  std::vector<PlanarShot> shots;
  for (int i = 0; i < 5; ++i) shots.push_back({PoseAt(3.0 * i, 0)});          // five new viewpoints
  for (int i = 0; i < 4; ++i) shots.push_back({PoseAt(3.0 * i + 0.1, 0.1)});  // four seen before
  for (int i = 0; i < 3; ++i) shots.push_back({Turned(PoseAt(20, 0), 20)});   // subject at the edge
  for (int i = 0; i < 2; ++i) shots.push_back({Turned(PoseAt(20, 0), 180)});  // back turned
  shots.push_back({PoseAt(20, 0, 0.1)});                                      // too near
  for (int i = 0; i < 2; ++i) shots.push_back({PoseAt(25, 0), Fault::kBlurred});
  shots.push_back({PoseAt(25, 0), Fault::kOverexposed});
  shots.push_back({PoseAt(25, 0), Fault::kBlack});
  for (int i = 0; i < 2; ++i) shots.push_back({PoseAt(25, 0), Fault::kNoPose});
  for (int i = 0; i < 3; ++i) shots.push_back({PoseAt(25, 0), Fault::kIncomplete});
  shots.push_back({PoseAt(25, 0)});  // at last

  const Captured captured = Capture(scratch / "lf", shots);
  EXPECT_EQ(Counted(captured.summary), (Counts{{"recorded", 6},
                                               {"covered", 4},
                                               {"outside_rectangle", 3},
                                               {"behind", 2},
                                               {"inside_sphere", 1},
                                               {"blur", 2},
                                               {"exposure", 2},
                                               {"tracking", 2}}));
  EXPECT_EQ(captured.summary.frames, 22u);
  EXPECT_EQ(captured.summary.device.incomplete, 3u) << "incomplete frames";
  EXPECT_EQ(captured.summary.stopped_because, StoppedBecause::kEnded);
  ASSERT_EQ(captured.light_field.views.size(), 6u);
  std::uint64_t sum = 0;
  for (const auto& [reason, count] : captured.light_field.reasons) sum += count;
  EXPECT_EQ(captured.light_field.reasons.size(), kReasons.size())
      << "every reason is on disk, also those of 0";
  EXPECT_EQ(sum, captured.summary.frames);
  EXPECT_EQ(captured.light_field.subject, kSubject);
}

TEST(CaptureSession, FastMotionIsNotRecorded) {
  const ScratchFolder scratch;
  std::vector<PlanarShot> shots;
  for (int i = 0; i < 6; ++i) shots.push_back({PoseAt(0.2 * i, 0)});
  for (int i = 1; i <= 6; ++i) shots.push_back({Turned(PoseAt(1 + 3.0 * i, 0), i % 2 ? 4 : -4)});
  PlanarDeviceOptions device;
  device.exposure_s = 0.02;  // of 0.067
  const Captured captured = Capture(scratch / "lf", shots, Options(), device);
  EXPECT_EQ(Counted(captured.summary), (Counts{{"recorded", 1}, {"covered", 5}, {"speed", 6}}));
  const ScratchFolder other;
  device.exposure_s = 0.0005;
  EXPECT_EQ(Counted(Capture(other / "lf", shots, Options(), device).summary),
            (Counts{{"recorded", 7}, {"covered", 5}}));
}

TEST(CaptureSession, RecordsExactlyUncoveredViews) {
  const ScratchFolder scratch;
  const std::vector<PlanarShot> shots = Sweep(10, 6, 0.7);
  const Captured captured = Capture(scratch / "lf", shots);
  const std::vector<CriterionView> views = CriterionViews(captured.light_field);
  ASSERT_GT(views.size(), 10u);
  ASSERT_LT(views.size(), shots.size() / 2);
  EXPECT_FALSE(captured.light_field.views[0].bound_px);
  for (std::size_t i = 1; i < views.size(); ++i) {
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < i; ++k) smallest = std::min(smallest, BoundPx(views[k], views[i], kSubject));
    ASSERT_GT(smallest, 7) << "view " << i << " was covered";
    ASSERT_TRUE(captured.light_field.views[i].bound_px);
    EXPECT_NEAR(*captured.light_field.views[i].bound_px, smallest, 1e-6);
  }
  for (const PlanarShot& shot : shots) {
    double smallest = std::numeric_limits<double>::infinity();
    const CriterionView candidate = CriterionView::From(kCamera, shot.cam_from_world, 640);
    for (const CriterionView& view : views) smallest = std::min(smallest, BoundPx(view, candidate, kSubject));
    ASSERT_LE(smallest, 7) << "a frame is neither recorded nor covered";
  }
}

TEST(CaptureSession, ThePhotographsAreThoseOfTheirPoses) {
  const ScratchFolder scratch;
  const std::vector<PlanarShot> shots{{PoseAt(0, 0)}, {PoseAt(5, 1)}, {PoseAt(-6, 2)}};
  const Captured captured = Capture(scratch / "lf", shots);
  ASSERT_EQ(captured.light_field.views.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    PlanarDevice again({shots[i]});
    again.Start();
    const cv::Mat expected = again.Next(std::chrono::milliseconds(0))->image.pixels;
    const View& view = captured.light_field.views[i];
    EXPECT_EQ(cv::norm(ReadViewImage(captured.light_field, view).pixels, expected, cv::NORM_INF), 0);
    EXPECT_LT((view.CenterInWorld() - shots[i].cam_from_world.OriginInSource()).norm(), 1e-9);
    EXPECT_NEAR(view.device_time_s, static_cast<double>(i) / 15, 1e-9);
  }
}

// What the device gave is what is recorded: no device writes into it again (acquisition/device/device.h).
TEST(CaptureSession, PixelsAreNotCopied) {
  const ScratchFolder scratch;
  std::vector<Frame> given;
  CaptureHooks hooks;
  hooks.keep_frame = [&](const Frame& frame) { given.push_back(frame); };
  const Captured captured = Capture(scratch / "lf", {{PoseAt(0, 0)}, {PoseAt(5, 1)}}, Options(), {}, hooks);
  ASSERT_TRUE(captured.summary.last_recorded);
  EXPECT_EQ(captured.summary.last_recorded->frame.image.pixels.data, given.back().image.pixels.data);
}

TEST(CaptureSession, StopsWhenTheCapIsCovered) {
  const ScratchFolder scratch;
  CaptureOptions options = Options();
  options.cap = Cap::ParseDegrees("12x8");
  options.until_share = 0.95;
  std::vector<PlanarShot> shots = Sweep(16, 12, 0.8);
  const std::size_t first_pass = shots.size();
  for (const PlanarShot& shot : Sweep(16.5, 12.5, 0.55)) shots.push_back(shot);
  std::vector<double> shown;
  CaptureHooks hooks;
  hooks.after_frame =
      hooks.while_waiting = [&](const SharedCaptureState& state) { shown.push_back(state->covered.value()); };
  const Captured captured = Capture(scratch / "lf", shots, options, {}, hooks);
  EXPECT_EQ(captured.summary.stopped_because, StoppedBecause::kCovered);
  EXPECT_LT(captured.summary.frames, shots.size());
  EXPECT_GT(captured.summary.frames, first_pass / 2);
  const LightFieldReport report = Describe(captured.light_field, {.cap = options.cap});
  EXPECT_GE(*report.covered, 0.95);
  // What is shown is what decides, and what is found on disk: the last frame's state, and the one at the end.
  EXPECT_NEAR(shown.back(), *report.covered, 1e-9);
  for (std::size_t i = 0; i + 2 < shown.size(); ++i) EXPECT_LT(shown[i], 0.95) << i;
  // One view less would not have done.
  LightField without = captured.light_field;
  without.views.pop_back();
  EXPECT_LT(*Describe(without, {.cap = options.cap}).covered, *report.covered);
}

TEST(CaptureSession, WithoutACapItGoesOn) {
  const ScratchFolder scratch;
  const Captured captured = Capture(scratch / "lf", Sweep(6, 4, 0.8));
  EXPECT_EQ(captured.summary.stopped_because, StoppedBecause::kEnded);
  EXPECT_FALSE(Describe(captured.light_field, {}).covered);
}

TEST(CaptureSession, StopRequestClosesTheLightField) {
  const ScratchFolder scratch;
  std::uint64_t frames = 0;
  CaptureHooks hooks;
  hooks.after_frame = [&](const SharedCaptureState& now) { frames = now->frames; };
  hooks.stop_requested = [&] { return frames >= 40; };
  const Captured captured = Capture(scratch / "lf", Sweep(16, 12, 0.8), Options(), {}, hooks);
  EXPECT_EQ(captured.summary.stopped_because, StoppedBecause::kSignal);
  EXPECT_EQ(captured.summary.frames, 40u);
  EXPECT_TRUE(fs::exists(scratch / "lf" / "transforms.json"));
  EXPECT_TRUE(fs::exists(scratch / "lf" / "sparse" / "0" / "images.txt"));
  EXPECT_EQ(captured.light_field.views.size(), captured.summary.recorded);
}

TEST(CaptureSession, LimitsOfFramesAndSecondsEndIt) {
  const ScratchFolder scratch;
  CaptureOptions options = Options();
  options.max_frames = 10;
  EXPECT_EQ(Capture(scratch / "a", Sweep(16, 12, 0.8), options).summary.frames, 10u);
  options.max_frames = 0;
  options.max_seconds = 2;
  const Captured captured = Capture(scratch / "b", Sweep(16, 12, 0.8), options);
  EXPECT_EQ(captured.summary.frames, 31u);
  EXPECT_NEAR(captured.light_field.capture_s, 2, 1e-9);
}

TEST(CaptureSession, ALostDeviceLeavesAClosedLightField) {
  const ScratchFolder scratch;
  const Captured captured = Capture(scratch / "lf", Sweep(6, 2, 1), Options(), {.lost_at_end = true});
  EXPECT_EQ(captured.summary.stopped_because, StoppedBecause::kDeviceLost);
  EXPECT_GT(captured.light_field.views.size(), 2u);
}

TEST(CaptureSession, ADiskThatRefusesEndsIt) {
  const ScratchFolder scratch;
  CaptureHooks hooks;
  hooks.after_frame = [&](const SharedCaptureState& now) {
    if (now->frames != 30) return;
    fs::remove_all(scratch / "lf" / "images");
    std::ofstream(scratch / "lf" / "images") << "in the way";
  };
  PlanarDevice device(Sweep(16, 12, 0.8));
  device.Start();
  const auto poses = MakeKnownPoseSource(kCamera, kSubject);
  const CaptureSummary summary =
      RunCapture(device, kCamera, *poses, NewWriter(scratch / "lf"), Options(), hooks);
  EXPECT_EQ(summary.stopped_because, StoppedBecause::kDisk);
  EXPECT_FALSE(summary.problem.empty());
  EXPECT_LT(summary.frames, 60u);
}

std::map<std::string, std::string> AllBytes(const fs::path& dir) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : fs::recursive_directory_iterator(dir)) {
    if (!entry.is_regular_file()) continue;
    bytes[fs::relative(entry.path(), dir).generic_string()] = ReadWholeFile(entry.path());
  }
  return bytes;
}

TEST(CaptureSession, DeterministicRunsGiveTheSameBytes) {
  const ScratchFolder scratch;
  CaptureOptions options = Options();
  options.cap = Cap::ParseDegrees("6x4");
  Capture(scratch / "a", Sweep(8, 5, 0.8), options);
  Capture(scratch / "b", Sweep(8, 5, 0.8), options);
  const auto a = AllBytes(scratch / "a"), b = AllBytes(scratch / "b");
  ASSERT_GT(a.size(), 10u);
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [name, bytes] : a) EXPECT_TRUE(b.count(name) && b.at(name) == bytes) << name << " differs";
}

TEST(CaptureSession, TwoThreadsRecordWhatOneDoes) {
  const ScratchFolder scratch;
  CaptureOptions options = Options();
  options.spool_views = 200;
  const Captured one = Capture(scratch / "a", Sweep(8, 5, 0.8), options);
  options.deterministic = false;
  const Captured two = Capture(scratch / "b", Sweep(8, 5, 0.8), options);
  ASSERT_EQ(one.light_field.views.size(), two.light_field.views.size());
  EXPECT_EQ(Counted(one.summary), Counted(two.summary));
  for (std::size_t i = 0; i < one.light_field.views.size(); ++i)
    EXPECT_EQ(one.light_field.views[i].device_time_s, two.light_field.views[i].device_time_s);
}

TEST(CaptureSession, FullSpoolPausesAndLosesNothing) {
  const ScratchFolder scratch;
  CaptureOptions options = Options();
  options.deterministic = false;
  options.spool_views = 1;
  PlanarDeviceOptions device;
  device.camera = CameraModel::Pinhole(1600, 1200, 1500);  // slow to encode
  std::vector<PlanarShot> shots;
  for (int i = 0; i < 12; ++i) shots.push_back({PoseAt(3.0 * i, 0)});
  const Captured captured = Capture(scratch / "lf", shots, options, device);
  const auto counted = Counted(captured.summary);
  ASSERT_TRUE(counted.count("spool")) << "the disk kept up";
  EXPECT_EQ(counted.at("spool") + counted.at("recorded"), 12u);
  EXPECT_EQ(captured.light_field.views.size(), counted.at("recorded"));
}

TEST(CaptureSession, ResumeGoesOnWhereItEnded) {
  const ScratchFolder scratch;
  const std::vector<PlanarShot> shots = Sweep(8, 5, 0.8);
  const auto half = shots.begin() + static_cast<std::ptrdiff_t>(shots.size() / 2);
  const Captured whole = Capture(scratch / "whole", shots);
  const Captured first = Capture(scratch / "lf", {shots.begin(), half});
  CaptureOptions options = Options();
  options.subject.reset();  // the light field has it
  PlanarDevice device({half, shots.end()});
  device.Start();
  const auto poses = MakeKnownPoseSource(kCamera, kSubject);
  const CaptureSummary summary =
      RunCapture(device, kCamera, *poses, LightFieldWriter::Resume(scratch / "lf"), options);
  const LightField resumed = ReadLightField(scratch / "lf");
  EXPECT_EQ(resumed.views.size(), whole.light_field.views.size());
  EXPECT_EQ(resumed.views.size(), first.light_field.views.size() + summary.recorded);
  EXPECT_EQ(resumed.reasons, whole.light_field.reasons);
  for (std::size_t i = 0; i < resumed.views.size(); ++i) {
    EXPECT_EQ(resumed.views[i].id, whole.light_field.views[i].id);
    EXPECT_LT((resumed.views[i].CenterInWorld() - whole.light_field.views[i].CenterInWorld()).norm(), 1e-9);
  }
}

TEST(CaptureSession, PosesFollowTheAdjustedMap) {
  const Rigid3 late_from_live{Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Vector3d::UnitZ())), {0.01, 0, 0}};
  enum class When { kAtTheEnd, kAtAnInterval, kAtOnce };
  for (const When when : {When::kAtTheEnd, When::kAtAnInterval, When::kAtOnce}) {
    const ScratchFolder scratch;
    DriftingSource poses(late_from_live);
    PlanarDevice device(Sweep(10, 4, 0.8));
    device.Start();
    CaptureOptions options = Options();
    options.frames_between_pose_updates = when == When::kAtOnce ? 1'000'000 : 10;
    CaptureHooks hooks;
    hooks.after_frame = [&](const SharedCaptureState& now) {
      if (when != When::kAtTheEnd && now->frames == 35) poses.Adjust(when == When::kAtOnce);
    };
    const CaptureSummary summary =
        RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), options, hooks);
    const LightField light_field = ReadLightField(scratch / "lf");
    ASSERT_GT(light_field.views.size(), 5u);
    for (const View& view : light_field.views)
      EXPECT_NEAR((late_from_live.Inverse() * view.CenterInWorld()).norm(), 1, 1e-9)
          << "live poses were at 1";
    EXPECT_LT(
        (summary.map->views().front().center_in_world - light_field.views.front().CenterInWorld()).norm(),
        1e-9);
    EXPECT_EQ(light_field.points.size(), 1u);
    std::ifstream journal(scratch / "lf" / "journal.jsonl");
    int updates = 0, views_after_update = 0;
    for (std::string line; std::getline(journal, line);) {
      updates += line.find("pose_update") != std::string::npos;
      views_after_update += updates > 0 && line.find("\"view\"") != std::string::npos;
    }
    EXPECT_GE(updates, 1);
    EXPECT_EQ(views_after_update > 0, when != When::kAtTheEnd) << "journaled while the capture goes on";
  }
}

TEST(CaptureSession, SubjectIsFoundFromTheTrackedPoints) {
  const ScratchFolder scratch;
  DriftingSource poses(Rigid3{});
  PlanarDevice device(Sweep(10, 4, 0.8));
  device.Start();
  CaptureOptions options = Options();
  options.subject.reset();
  const CaptureSummary summary = RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), options);
  ASSERT_TRUE(summary.subject);
  EXPECT_EQ(summary.reasons[static_cast<std::size_t>(Reason::kTracking)],
            static_cast<std::uint64_t>(options.stable_frames - 1));
  EXPECT_LT(summary.subject->center_in_world.norm(), 0.02)
      << "the plane's middle is what the camera looks at";
  // 0.28 of the width of the image, which is about 0.15 of the distance.
  const auto outline = SphereOutline(kCamera, PoseAt(0, 0), *summary.subject);
  double low = 1e9, high = 0;
  for (const auto& img : *outline) low = std::min(low, img.x()), high = std::max(high, img.x());
  EXPECT_NEAR((high - low) / kCamera.width, 0.28, 0.006);
  EXPECT_EQ(ReadLightField(scratch / "lf").subject, summary.subject);
}

TEST(CaptureSession, WithoutASubjectNothingIsRecorded) {
  const ScratchFolder scratch;
  CaptureOptions options = Options();
  options.subject.reset();
  const Captured captured = Capture(scratch / "lf", Sweep(4, 2, 1), options);
  EXPECT_EQ(Counted(captured.summary), (Counts{{"tracking", captured.summary.frames}}));
  EXPECT_EQ(captured.light_field.views.size(), 0u);
  EXPECT_EQ(captured.summary.map, nullptr);
}

TEST(SafetyRectangle, HoldsTheSilhouetteOrNot) {
  const SafetyRectangle rectangle = SafetyRectangle::Of(kCamera);
  EXPECT_LT((rectangle.low - Eigen::Vector2d(32, 24)).norm(), 1e-9);
  EXPECT_LT((rectangle.high - Eigen::Vector2d(288, 216)).norm(), 1e-9);
  // The sphere's image is 91 px wide, a little more off the axis; its centre may go about 128 - 48 = 80 px
  // aside: 15 degrees.
  for (const auto& [yaw_deg, held] :
       {std::pair{0.0, true}, {13.5, true}, {16.5, false}, {-13.5, true}, {-16.5, false}}) {
    const auto outline = SphereOutline(kCamera, Turned(PoseAt(0, 0), yaw_deg), kSubject);
    ASSERT_TRUE(outline);
    EXPECT_EQ(rectangle.Holds(*outline), held) << yaw_deg;
  }
  EXPECT_FALSE(SphereOutline(kCamera, PoseAt(0, 0, 0.1), kSubject)) << "from inside there is no silhouette";
}

TEST(SphereOutline, PointsAreWhereTheSphereEnds) {
  CameraModel camera = kCamera;
  camera.distortion = Distortion::kRadialTangential;
  camera.coefficients = {-0.15, 0.02, 0.001, 0, 0};
  const Rigid3 cam_from_world = Turned(PoseAt(10, 5), 9);
  const auto outline = SphereOutline(camera, cam_from_world, kSubject);
  ASSERT_TRUE(outline);
  const Vector3d center_in_cam = cam_from_world * kSubject.center_in_world;
  for (const auto& img : *outline) {
    const Vector3d ray = *camera.RayFromImg(img);
    EXPECT_NEAR(ray.cross(center_in_cam).norm(), kSubject.radius, 1e-6);
  }
}

}  // namespace
}  // namespace ulf::test::capture_session_test
