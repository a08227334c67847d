// Tests: coverage/session/capture_gaps, coverage/session/record/view_spool.
//
// A capture whose cable is pulled, whose disk is full or slow: it goes on, and nothing recorded is lost.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "acquisition/device/reconnecting_device.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "coverage/session/capture_session.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/planar_device.h"
#include "tests/support/slow_disk.h"
#include "tests/support/test_paths.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test::holding_up_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using Eigen::Vector3d;
using ::testing::HasSubstr;

const Subject kSubject{Vector3d::Zero(), 0.15};

// A hand that goes round the subject, each step a new viewpoint.
std::vector<PlanarShot> Arc(int count, double first_deg = -40) {
  std::vector<PlanarShot> shots;
  for (int i = 0; i < count; ++i) {
    const double azimuth = (first_deg + 2.0 * i) * M_PI / 180;
    shots.push_back({LookAt({std::sin(azimuth), 0, std::cos(azimuth)}, Vector3d::Zero(), Vector3d::UnitY())});
  }
  return shots;
}

CaptureOptions Options(bool deterministic = false) {
  CaptureOptions options;
  options.subject = kSubject;
  options.deterministic = deterministic;
  options.spool_views = 64;  // these frames come faster than any camera's
  return options;
}

CaptureSummary Capture(Device& device, const CameraModel& camera, const fs::path& dir,
                       const CaptureOptions& options, const CaptureHooks& hooks) {
  CaptureHeader header;
  header.camera = camera;
  const auto poses = MakeKnownPoseSource(camera, options.subject);
  device.Start();
  return RunCapture(device, camera, *poses, LightFieldWriter::Create(dir, header), options, hooks);
}

std::vector<nlohmann::json> Gaps(const fs::path& dir) {
  std::vector<nlohmann::json> gaps;
  std::ifstream journal(dir / "journal.jsonl");
  for (std::string line; std::getline(journal, line);)
    if (const auto event = JsonFromText(line); event["event"] == "gap") gaps.push_back(event);
  return gaps;
}

// Every photograph on disk belongs to a view and is whole; nothing temporary stays.
void ExpectNothingHalfWritten(const fs::path& dir) {
  const LightField light_field = ReadLightField(dir);
  std::size_t photographs = 0;
  for (const auto& entry : fs::recursive_directory_iterator(dir)) {
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
    photographs += entry.path().parent_path().filename() == "images";
  }
  EXPECT_EQ(photographs, light_field.views.size());
  for (const View& view : light_field.views) EXPECT_NO_THROW(ReadViewImage(light_field, view)) << view.id;
}

// A camera whose cable is out for a while after `first` shots.
std::unique_ptr<Device> PulledAfter(int first, std::vector<PlanarShot> shots, Clock::duration out) {
  const std::vector<PlanarShot> before(shots.begin(), shots.begin() + first),
      after(shots.begin() + first, shots.end());
  auto back = std::make_shared<std::optional<Clock::time_point>>();  // of the searching thread only
  PlanarDeviceOptions options;
  options.lost_at_end = true;
  return MakeReconnectingDevice(
      std::make_unique<PlanarDevice>(before, options),
      {.where_it_was = [after, back, out](const DeviceInfo&) -> std::unique_ptr<Device> {
         if (!*back) *back = Clock::now() + out;
         if (Clock::now() < **back) throw Error("planar: the cable is out");
         return std::make_unique<PlanarDevice>(after);
       },
       .elsewhere = nullptr});
}

TEST(HoldingUp, ACaptureGoesOnWhenTheCableIsBack) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  const auto device = PulledAfter(15, Arc(40), 700ms);
  std::vector<std::string> said, waited;
  std::vector<double> times_s;
  CaptureHooks hooks;
  hooks.say = [&](const std::string& line) {
    if (line.find("views at") == std::string::npos) said.push_back(line);  // what to expect, before the first
  };
  hooks.while_waiting = [&](const SharedCaptureState& now) {
    if (!now->why_waiting.empty()) waited.push_back(now->why_waiting);
  };
  hooks.after_frame = [&](const SharedCaptureState& now) { times_s.push_back(now->device_time_s); };
  const CaptureSummary summary = Capture(*device, PlanarDeviceOptions{}.camera, dir, Options(), hooks);
  EXPECT_EQ(summary.stopped_because, StoppedBecause::kEnded);
  EXPECT_EQ(summary.frames, 40u);
  EXPECT_EQ(summary.device.reconnects, 1u);
  EXPECT_EQ(summary.device.delivered, 40u);
  EXPECT_EQ(summary.events.at("faulted"), 1u);
  EXPECT_EQ(summary.events.at("restored"), 1u);
  EXPECT_EQ(ReadLightField(dir).views.size(), 40u);
  ExpectNothingHalfWritten(dir);

  const auto gaps = Gaps(dir);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_DOUBLE_EQ(gaps[0]["from_s"], times_s[14]);
  EXPECT_DOUBLE_EQ(gaps[0]["to_s"], times_s[15]);
  EXPECT_GT(times_s[15] - times_s[14], 0.6) << "as long as the cable was out";
  EXPECT_THAT(gaps[0]["reason"].get<std::string>(), HasSubstr("device: "));
  ASSERT_EQ(said.size(), 3u);
  EXPECT_THAT(said[0], HasSubstr("no longer answers"));
  EXPECT_THAT(said[2], HasSubstr("streams again"));
  ASSERT_FALSE(waited.empty());
  EXPECT_THAT(waited.back(), AllOf(HasSubstr("reconnecting"), HasSubstr("no longer answers")));
}

TEST(HoldingUp, AStopWhileTheCableIsOutClosesAtOnce) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  const auto device = PulledAfter(15, Arc(40), 1h);
  int waited = 0;
  CaptureHooks hooks;
  hooks.while_waiting = [&](const SharedCaptureState&) { ++waited; };
  hooks.stop_requested = [&] { return waited > 3; };
  const CaptureSummary summary = Capture(*device, PlanarDeviceOptions{}.camera, dir, Options(), hooks);
  EXPECT_EQ(summary.stopped_because, StoppedBecause::kSignal);
  EXPECT_EQ(ReadLightField(dir).views.size(), 15u);
  EXPECT_TRUE(fs::exists(dir / "transforms.json"));
  const auto gaps = Gaps(dir);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_GT(gaps[0]["to_s"].get<double>(), gaps[0]["from_s"].get<double>());
}

// Filled while a view is being encoded and when none is; with the thread that writes, and without.
TEST(HoldingUp, FullDiskPausesRecordingUntilThereIsRoom) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 96 << 20)) GTEST_SKIP() << *problem;
  for (const bool deterministic : {false, true}) {
    const fs::path dir = scratch / (deterministic ? "one" : "two"), ballast = scratch / "ballast";
    PlanarDeviceOptions planar;
    planar.camera = CameraModel::Pinhole(640, 480, 600);
    PlanarDevice device(Arc(60), planar);
    std::vector<std::string> said;
    std::string why_waiting;
    std::size_t views_when_full = 0, views_before_room = 0;
    CaptureHooks hooks;
    hooks.say = [&](const std::string& line) {
      if (line.find("views at") == std::string::npos)
        said.push_back(line);  // what to expect, before the first
    };
    hooks.after_frame = [&](const SharedCaptureState& now) {
      if (now->frames == 15) FillDisk(ballast), views_when_full = now->view_ids.size();
      if (now->frames == 40)
        why_waiting = now->why_waiting, views_before_room = now->view_ids.size(), fs::remove(ballast);
      std::this_thread::sleep_for(now->frames == 40 ? 1500ms
                                                    : 5ms);  // the disk is asked three times a second
    };
    const CaptureSummary summary = Capture(device, planar.camera, dir, Options(deterministic), hooks);
    EXPECT_EQ(summary.stopped_because, StoppedBecause::kEnded) << summary.problem;
    EXPECT_EQ(summary.frames, 60u) << "tracking goes on";
    EXPECT_EQ(views_before_room, views_when_full) << "nothing is taken that has no room";
    EXPECT_EQ(summary.recorded, 15u + 20u);
    EXPECT_EQ(summary.reasons[static_cast<std::size_t>(Reason::kDisk)], 25u);
    EXPECT_THAT(why_waiting, ::testing::ContainsRegex(
                                 "^recording paused: disk full \\([0-9.]+ MB free, [0-9.]+ needed\\)"));
    EXPECT_THAT(why_waiting, HasSubstr(dir.string()));
    EXPECT_EQ(summary.pauses, 1u);
    EXPECT_EQ(summary.unwritten, 0u);
    ASSERT_EQ(said.size(), 2u);
    EXPECT_THAT(said[0], HasSubstr("recording paused"));
    EXPECT_EQ(ReadLightField(dir).views.size(), summary.recorded) << "what was taken is written";
    ExpectNothingHalfWritten(dir);
    const auto gaps = Gaps(dir);
    ASSERT_EQ(gaps.size(), 1u);
    EXPECT_THAT(gaps[0]["reason"].get<std::string>(), HasSubstr("disk full"));
    EXPECT_NEAR(gaps[0]["to_s"].get<double>() - gaps[0]["from_s"].get<double>(), 25.0 / 15, 0.2);
  }
}

TEST(HoldingUp, StoppedOnAFullDiskItIsWholeAndReadable) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 24 << 20)) GTEST_SKIP() << *problem;
  const fs::path dir = scratch / "lf", ballast = scratch / "ballast";
  PlanarDevice device(Arc(40));
  CaptureHooks hooks;
  hooks.after_frame = [&](const SharedCaptureState& now) {
    if (now->frames == 20) FillDisk(ballast);
  };
  const CaptureSummary summary = Capture(device, PlanarDeviceOptions{}.camera, dir, Options(true), hooks);
  EXPECT_EQ(summary.stopped_because, StoppedBecause::kDisk);
  EXPECT_THAT(summary.problem, HasSubstr("free some space"));
  EXPECT_EQ(ReadLightField(dir).views.size(), 20u) << "also while the disk is still full";
  ExpectNothingHalfWritten(dir);
  fs::remove(ballast);
  EXPECT_NO_THROW(LightFieldWriter::Resume(dir));
  EXPECT_TRUE(fs::exists(dir / "transforms.json")) << "made up for";
}

void WaitForViewsOnDisk(const fs::path& dir, std::size_t views) {
  const auto until = Clock::now() + 60s;
  while (ReadJournal(dir / "journal.jsonl").light_field.views.size() < views && Clock::now() < until)
    std::this_thread::sleep_for(1ms);
}

// Frames come as fast as they can be tracked while every wait for the disk takes a fifth of a second, and a
// view needs three; then the disk is as quick as it really is, and frames come at its pace.
TEST(HoldingUp, ASlowDiskPausesAndIsNoted) {
  for (const bool slow : {true, false}) {
    const ScratchFolder scratch;
    const fs::path dir = scratch / "lf";
    CaptureOptions options = Options();
    options.spool_views = 4;
    PlanarDevice device(Arc(60));
    std::optional<SlowDisk> disk;
    if (slow) disk.emplace(SlowDisk::Speed{200ms, 100e6});
    std::vector<std::string> said;
    std::size_t views_while_slow = 0;
    CaptureHooks hooks;
    hooks.say = [&](const std::string& line) {
      if (line.find("views at") == std::string::npos)
        said.push_back(line);  // what to expect, before the first
    };
    hooks.after_frame = [&](const SharedCaptureState& now) {
      if (slow && now->frames < 40) return;
      if (slow && now->frames == 40) {
        views_while_slow = now->view_ids.size();
        EXPECT_THAT(now->why_waiting, HasSubstr("disk slow"));
        disk.reset();
      }
      WaitForViewsOnDisk(dir, now->view_ids.size());
    };
    const CaptureSummary summary = Capture(device, PlanarDeviceOptions{}.camera, dir, options, hooks);
    EXPECT_EQ(summary.frames, 60u) << "tracking goes on";
    EXPECT_EQ(summary.recorded + summary.reasons[static_cast<std::size_t>(Reason::kSpool)], 60u);
    EXPECT_EQ(ReadLightField(dir).views.size(), summary.recorded) << "what was taken is written";
    EXPECT_EQ(summary.unwritten, 0u);
    ExpectNothingHalfWritten(dir);
    const auto gaps = Gaps(dir);
    EXPECT_EQ(gaps.size(), summary.pauses);
    if (!slow) {
      EXPECT_EQ(summary.recorded, 60u) << "the pauses come from the disk";
      EXPECT_EQ(summary.pauses, 0u);
      continue;
    }
    EXPECT_LT(views_while_slow, 30u);
    EXPECT_GE(summary.recorded, views_while_slow + 15) << "it goes on when the disk has caught up";
    ASSERT_GE(summary.pauses, 1u);
    EXPECT_GE(summary.paused_s, 0.5);
    EXPECT_THAT(gaps[0]["reason"].get<std::string>(), HasSubstr("disk slow"));
    ASSERT_GE(said.size(), 2u);
    EXPECT_THAT(said[0], AllOf(HasSubstr("recording paused, tracking goes on"), HasSubstr("disk slow")));
    EXPECT_THAT(said[1], HasSubstr("recording goes on"));
  }
}

// Not full, but in no state to be written to: what was recorded stays, what was taken is kept elsewhere, and
// the counts say what is where.
TEST(HoldingUp, FailingDiskEndsTheCaptureCountingFrames) {
  for (const bool deterministic : {false, true}) {
    const ScratchFolder scratch;
    const fs::path dir = scratch / "lf";
    PlanarDevice device(Arc(60));
    CaptureHooks hooks;
    hooks.after_frame = [&](const SharedCaptureState& now) {
      if (now->frames < 10) return;
      WaitForViewsOnDisk(dir, 10);
      if (now->frames > 10 || now->view_ids.size() < 10) return;
      fs::rename(dir / "images", scratch / "images");
      std::ofstream(dir / "images") << "in the way";
    };
    const CaptureSummary summary =
        Capture(device, PlanarDeviceOptions{}.camera, dir, Options(deterministic), hooks);
    EXPECT_EQ(summary.stopped_because, StoppedBecause::kDisk);
    EXPECT_THAT(summary.problem, HasSubstr("images"));
    EXPECT_EQ(summary.recorded, 10u);
    EXPECT_EQ(summary.unwritten, 0u);
    ASSERT_EQ(summary.set_aside.size(), 1u);
    EXPECT_EQ(summary.set_aside.begin()->first, dir / "unposed");
    const std::uint64_t taken = summary.reasons[static_cast<std::size_t>(Reason::kRecorded)];
    EXPECT_EQ(summary.set_aside.begin()->second, taken - 10);
    EXPECT_GE(taken, 11u);
    EXPECT_EQ(std::distance(fs::directory_iterator(dir / "unposed"), {}),
              static_cast<std::ptrdiff_t>(taken - 10));
    fs::remove(dir / "images");
    fs::rename(scratch / "images", dir / "images");
    EXPECT_EQ(ReadLightField(dir).views.size(), 10u);
    ExpectNothingHalfWritten(dir);
  }
}

}  // namespace
}  // namespace ulf::test::holding_up_test
