// Tests: coverage/session/capture_session, coverage/session/record/view_spool,
// acquisition/device/reconnecting_device, core/light_field/folder/light_field_writer,
// core/light_field/folder/opened_folder.
//
// What a capture keeps through each fault, counted: rows of docs/measured/cameras.md.
#include <gmock/gmock.h>
#include <sys/mount.h>

#include <cerrno>
#include <cstdlib>
#include <future>
#include <set>
#include <thread>

#include "acquisition/device/reconnecting_device.h"
#include "acquisition/simulator/simulated_device.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/coverage/session/kept_views.h"
#include "tests/support/child_process.h"
#include "tests/support/host_clock.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/scripted_device.h"
#include "tests/support/slow_disk.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test::capture_faults_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

std::uint64_t Taken(const CaptureSummary& summary) {
  return summary.reasons[static_cast<std::size_t>(Reason::kRecorded)];
}

std::size_t SetAside(const CaptureSummary& summary) {
  std::size_t views = 0;
  for (const auto& [folder, count] : summary.set_aside) views += count;
  return views;
}

// ---- The disk. ----

// From the end of the fault to the first view after it.
struct GoesOn {
  std::optional<Clock::time_point> ended_at;
  std::size_t views_before = 0;
  std::optional<double> after_s;
  void End(const CaptureState& now) { ended_at = Clock::now(), views_before = now.view_ids.size(); }
  void Look(const CaptureState& now) {
    if (ended_at && !after_s && now.view_ids.size() > views_before) after_s = SecondsSince(*ended_at);
  }
};

TEST(CaptureFaults, AFullDiskLosesNoView) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 32 << 20)) GTEST_SKIP() << *problem;
  int tried = 0;
  std::uint64_t lost = 0;
  double longest_s = 0;
  for (const int full_at : {0, 10}) {
    const fs::path dir = scratch / fmt::format("lf{}", full_at), ballast = scratch / "ballast";
    GoesOn goes_on;
    CaptureHooks hooks;
    hooks.after_frame = [&](const SharedCaptureState& now) {
      if (now->frames == static_cast<std::uint64_t>(full_at) + 1) FillDisk(ballast);
      if (now->frames == 20) fs::remove(ballast), goes_on.End(*now);
      goes_on.Look(*now);
      if (now->frames >= 20 && !goes_on.after_s) std::this_thread::sleep_for(50ms);
    };
    const Captured captured = Capture(dir, Arc(55), InThreads(), {}, hooks);
    ++tried;
    lost += Taken(captured.summary) - captured.light_field.views.size();
    EXPECT_EQ(Photographs(dir).size(), Taken(captured.summary)) << full_at;
    EXPECT_GT(captured.summary.reasons[static_cast<std::size_t>(Reason::kDisk)], 0u) << full_at;
    ASSERT_TRUE(goes_on.after_s) << full_at;
    longest_s = std::max(longest_s, *goes_on.after_s);
    fs::remove_all(dir);
  }
  EXPECT_EQ(lost, 0u);
  PrintFaultRow("disk full in mid-capture, then room again", tried, fmt::format("{} views", lost), longest_s);
}

TEST(CaptureFaults, ASlowDiskLosesNoView) {
  int tried = 0;
  std::uint64_t lost = 0, paused = 0;
  double longest_s = 0;
  for (const auto wait : {100ms, 400ms}) {
    const ScratchFolder scratch;
    CaptureOptions options = InThreads();
    options.spool_views = 4;
    std::optional<SlowDisk> disk(std::in_place, SlowDisk::Speed{wait, 10e6});
    GoesOn goes_on;
    CaptureHooks hooks;
    hooks.after_frame = [&](const SharedCaptureState& now) {
      if (now->frames == 30) disk.reset(), goes_on.End(*now);
      goes_on.Look(*now);
      if (now->frames >= 30 && !goes_on.after_s) std::this_thread::sleep_for(20ms);
    };
    const Captured captured = Capture(scratch / "lf", Arc(55), options, {}, hooks);
    ++tried;
    lost += Taken(captured.summary) - Photographs(scratch / "lf").size();
    paused += captured.summary.pauses;
    ASSERT_TRUE(goes_on.after_s);
    longest_s = std::max(longest_s, *goes_on.after_s);
  }
  EXPECT_EQ(lost, 0u);
  EXPECT_GE(paused, 2u) << "the disk was quick enough: the test shows nothing";
  PrintFaultRow("disk slower than the views, then quick again", tried, fmt::format("{} views", lost),
                longest_s);
}

// As a kernel turns it when it finds errors on it: whatever is written is refused.
TEST(CaptureFaults, ADiskTurnedReadOnlyEndsIt) {
  int tried = 0;
  std::size_t taken = 0, unwritten = 0, recorded_lost = 0;
  double longest_s = 0;
  for (const bool threads : {false, true})
    for (const int at : {1, 7}) {
      const ScratchFolder scratch;
      const fs::path dir = scratch / "lf";
      std::optional<RefusingDisk> disk;
      std::map<int, std::string> before;
      CaptureHooks hooks;
      hooks.after_frame = [&](const SharedCaptureState& now) {
        if (now->frames != static_cast<std::uint64_t>(at)) return;
        for (const auto until = Clock::now() + 20s; before.size() < static_cast<std::size_t>(at);) {
          ASSERT_LT(Clock::now(), until);
          before = Photographs(dir);
        }
        disk.emplace(EROFS);
      };
      PlanarDevice device(Arc(40));
      device.Start();
      const auto poses = MakeKnownPoseSource(kCamera, kSubject);
      const CaptureSummary summary =
          RunCapture(device, kCamera, *poses, NewWriter(dir), threads ? InThreads() : Options(), hooks);
      ++tried;
      EXPECT_EQ(summary.stopped_because, StoppedBecause::kDisk);
      EXPECT_THAT(summary.problem, HasSubstr("Read-only file system"));
      EXPECT_EQ(summary.recorded, static_cast<std::uint64_t>(at));
      EXPECT_EQ(Taken(summary), summary.recorded + summary.unwritten + SetAside(summary))
          << "every frame that was taken is somewhere, or counted";
      taken += Taken(summary);
      unwritten += summary.unwritten;
      disk.reset();
      const auto again = Clock::now();
      GoOn(dir);
      longest_s = std::max(longest_s, SecondsSince(again));
      recorded_lost += static_cast<std::size_t>(Lost(before, Photographs(dir)));
    }
  EXPECT_EQ(recorded_lost, 0u);
  PrintFaultRow(
      "disk becomes read-only in mid-capture (it ends, and says so; resumed when it can be written)", tried,
      fmt::format("{} recorded views; of {} taken, {} under way, counted", recorded_lost, taken, unwritten),
      longest_s);
}

TEST(CaptureFaults, AReadOnlyDiskEndsItAtTheStart) {
  const ScratchFolder scratch;
  if (const auto problem = MountSmallDisk(scratch.path(), 24 << 20)) GTEST_SKIP() << *problem;
  const fs::path dir = scratch / "lf";
  const Captured captured = Capture(dir, Arc(4));
  const auto before = Photographs(dir);
  const auto mount_again = [&](unsigned long flags) {
    return mount(nullptr, scratch.path().c_str(), nullptr, MS_REMOUNT | flags, nullptr);
  };
  ASSERT_EQ(mount_again(MS_RDONLY), 0);
  const auto refusal = ThrowsMessage<Error>(HasSubstr("Read-only file system"));
  EXPECT_THAT([&] { NewWriter(scratch / "new"); }, refusal);
  EXPECT_THAT([&] { LightFieldWriter::Resume(dir); }, refusal);
  EXPECT_EQ(Photographs(dir), before) << "it can be read";
  ASSERT_EQ(mount_again(0), 0);
  const auto again = Clock::now();
  GoOn(dir);
  const double go_on_s = SecondsSince(again);
  const int lost = Lost(before, Photographs(dir));
  EXPECT_EQ(lost, 0);
  PrintFaultRow("disk read-only from the start: refused, begun anew or resumed", 2,
                fmt::format("{} views", lost), go_on_s);
}

// Moved away or deleted by another program while the capture runs: it ends. What was moved is whole; of what
// was deleted the views taken since are set aside.
TEST(CaptureFaults, ARemovedFolderEndsIt) {
  int tried = 0, moved_lost = 0;
  std::size_t uncounted = 0;
  double longest_s = 0;
  for (const bool deleted : {false, true})
    for (const bool threads : {false, true}) {
      const ScratchFolder scratch;
      const fs::path dir = scratch / "lf", elsewhere = scratch / "elsewhere";
      std::map<int, std::string> before;
      CaptureHooks hooks;
      hooks.after_frame = [&](const SharedCaptureState& now) {
        if (now->frames != 8) return;
        for (const auto until = Clock::now() + 20s; before.size() < 8;) {
          ASSERT_LT(Clock::now(), until);
          before = Photographs(dir);
        }
        fs::rename(dir, elsewhere);
        if (deleted) fs::remove_all(elsewhere);
      };
      PlanarDevice device(Arc(40));
      device.Start();
      const auto poses = MakeKnownPoseSource(kCamera, kSubject);
      const CaptureSummary summary =
          RunCapture(device, kCamera, *poses, NewWriter(dir), threads ? InThreads() : Options(), hooks);
      ++tried;
      EXPECT_EQ(summary.stopped_because, StoppedBecause::kDisk) << deleted << threads;
      EXPECT_THAT(summary.problem, HasSubstr(dir.string())) << deleted << threads;
      EXPECT_LT(summary.frames, 40u) << "it does not go on as if nothing were";
      std::size_t aside = 0;
      for (const auto& [folder, count] : summary.set_aside) {
        aside += count;
        for (const auto& file : fs::recursive_directory_iterator(folder))
          if (file.is_regular_file()) {
            EXPECT_NO_THROW(ReadImageFile(file.path().string())) << file.path();
          }
      }
      EXPECT_EQ(Taken(summary), 8 + summary.unwritten + aside) << deleted << threads;
      uncounted += Taken(summary) - 8 - aside;
      if (deleted) continue;
      const auto again = Clock::now();
      GoOn(elsewhere);
      longest_s = std::max(longest_s, SecondsSince(again));
      moved_lost += Lost(before, Photographs(elsewhere));
    }
  EXPECT_EQ(moved_lost, 0);
  PrintFaultRow("folder moved away or deleted in mid-capture (it ends, names both places, makes none anew)",
                tried,
                fmt::format("{} views of a folder that was moved; {} taken since and not set aside",
                            moved_lost, uncounted),
                longest_s);
}

// The same with frames that have masters, in folders of their own, and in every step of closing: never is a
// folder made anew under the old name, and both names are said.
TEST(CaptureFaults, ARemovedFolderIsNotMadeAnew) {
  for (const char* at : {"a frame", "the last views to the disk",
                         "poses, points and the files for other programs", "depth maps and the mesh"})
    for (const bool deleted : {false, true}) {
      const ScratchFolder scratch;
      const fs::path dir = scratch / "lf", elsewhere = scratch / "elsewhere";
      const auto device = OpenSimulatedDevice(
          DeviceUri::Parse("sim:studio?width=160&height=120&fps=15&seed=5&speed_deg_s=30&look_away=0"));
      device->Start();
      CaptureOptions options = InThreads();
      options.subject = Subject{{0, 0, 0.07}, 0.162};
      options.max_frames = 30;
      options.geometry = true;
      std::vector<std::string> said;
      CaptureHooks hooks;
      hooks.say = [&](const std::string& line) { said.push_back(line); };
      const auto remove = [&] {
        fs::rename(dir, elsewhere);
        if (deleted) fs::remove_all(elsewhere);
      };
      bool removed = false;
      hooks.after_frame = [&](const SharedCaptureState& now) {
        if (at != std::string("a frame") || removed || now->view_ids.size() < 5) return;
        removed = true;
        remove();
      };
      hooks.closing = [&](const std::string& step) {
        if (step != at || removed) return;
        removed = true;
        remove();
      };
      const auto poses = MakeKnownPoseSource(*device->Camera(), options.subject);
      const CaptureSummary summary =
          RunCapture(*device, *device->Camera(), *poses, NewWriter(dir, *device->Camera()), options, hooks);
      ASSERT_TRUE(removed) << at;
      EXPECT_FALSE(fs::exists(dir)) << at << ": made anew";
      EXPECT_EQ(summary.stopped_because, StoppedBecause::kDisk) << at;
      EXPECT_THAT(summary.problem, HasSubstr(dir.string() + ": the folder ")) << at;
      // A thread may look between the two steps.
      EXPECT_THAT(summary.problem,
                  AnyOf(HasSubstr(elsewhere.string()), HasSubstr(deleted ? "deleted" : "moved to")))
          << at;
      EXPECT_FALSE(summary.geometry) << at;
      for (const std::string& line : said) EXPECT_THAT(line, Not(HasSubstr("complete"))) << at;
      if (deleted) continue;
      EXPECT_GE(Photographs(elsewhere).size(), 1u) << at;
    }
}

TEST(CaptureFaults, CommandReportsARemovedFolder) {
  const char* const ulf = std::getenv("ULF_BINARY");
  if (!ulf) GTEST_SKIP() << "ULF_BINARY names no program";
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf", elsewhere = scratch / "elsewhere";
  ChildProcess capture(
      {"/bin/sh", "-c",
       fmt::format(
           "exec '{}' capture 'sim:studio?width=160&height=120&seed=5&speed_deg_s=30&look_away=0' "
           "--headless --no-geometry --poses known --subject 0,0,0.07,0.162 --max-seconds 60 -o '{}' 2>&1",
           ulf, dir.string())});
  for (const auto until = Clock::now() + 60s; !fs::exists(dir / "masters/000003.tif");) {
    ASSERT_LT(Clock::now(), until);
    std::this_thread::sleep_for(20ms);
  }
  fs::rename(dir, elsewhere);
  const std::string said = capture.ReadUntil("no such line", 60);
  EXPECT_EQ(capture.Wait(10), 1);
  EXPECT_THAT(said,
              AllOf(HasSubstr("ulf: " + dir.string() + ": the folder was moved to " + elsewhere.string()),
                    Not(HasSubstr("complete")), Not(HasSubstr("recording goes on"))));
  EXPECT_FALSE(fs::exists(dir));
}

// ---- The clock. ----

// The same capture with true time, set back by an hour, forward by two.
TEST(CaptureFaults, AClockSetBackLosesNoView) {
  const double before_s = EpochSeconds();
  ShiftHostClock(-3600);
  ASSERT_NEAR(EpochSeconds() - before_s, -3600, 60) << "the clock was not set";
  ShiftHostClock(0);
  const ScratchFolder scratch;
  const auto captured = [&](const std::string& name, bool set) {
    const auto device =
        OpenSimulatedDevice(DeviceUri::Parse("sim:studio?width=160&height=120&fps=15&seed=5&speed_deg_s=30"));
    device->Start();
    CaptureOptions options = InThreads();
    options.subject = Subject{{0, 0, 0.07}, 0.162};
    options.max_frames = 90;
    options.spool_views = 90;
    CaptureHooks hooks;
    hooks.after_frame = [&](const SharedCaptureState& now) {
      if (set && now->frames == 30) ShiftHostClock(-3600);
      if (set && now->frames == 60) ShiftHostClock(7200);
    };
    const auto poses = MakeKnownPoseSource(*device->Camera(), options.subject);
    const CaptureSummary summary = RunCapture(*device, *device->Camera(), *poses,
                                              NewWriter(scratch / name, *device->Camera()), options, hooks);
    ShiftHostClock(0);
    EXPECT_EQ(summary.frames, 90u) << name;
    EXPECT_EQ(summary.pauses, 0u) << name;
    const LightField light_field = ReadLightField(scratch / name);
    EXPECT_GT(light_field.capture_s, 4) << name;
    EXPECT_LT(light_field.capture_s, 8) << name << ": measured by the clock that was set";
    for (std::size_t i = 1; i < light_field.views.size(); ++i)
      EXPECT_GT(light_field.views[i].device_time_s, light_field.views[i - 1].device_time_s) << name;
    EXPECT_TRUE(light_field.doubts.empty()) << name;
    return Photographs(scratch / name);
  };
  const auto truth = captured("true", false), set = captured("set", true);
  EXPECT_GT(truth.size(), 10u);
  const int lost = Lost(truth, set);
  EXPECT_EQ(lost, 0);
  EXPECT_EQ(set.size(), truth.size());
  PrintFaultRow("computer's clock set back by an hour, then forward by two, in mid-capture", 2,
                fmt::format("{} views", lost), std::nullopt);
}

// ---- The camera. ----

struct OtherCamera {
  const char *maker, *model, *serial;
};

// The cable goes out while the clock is set back: the gap is as long as it was by the camera's own time.
TEST(CaptureFaults, ACameraThatGoesComesBackOrIsAnother) {
  // By its serial number; by maker and model, where both have no serial number, or the same.
  struct Swap {
    const char* serial;
    std::optional<OtherCamera> other;
  };
  const std::vector<Swap> swaps{{"S1", {}},
                                {"S1", OtherCamera{"test", "scripted", "another"}},
                                {"S1", OtherCamera{"another", "scripted", ""}},
                                {"", OtherCamera{"another", "scripted", ""}},
                                {"", OtherCamera{"test", "another", ""}},
                                {"S1", OtherCamera{"another", "another", "S1"}}};
  double longest_s = 0;
  int tried = 0, refused = 0, backward = 0;
  for (const Swap& swap : swaps) {
    const std::string which = fmt::format(
        "serial '{}', then {}", swap.serial,
        swap.other ? fmt::format("{} {} '{}'", swap.other->maker, swap.other->model, swap.other->serial)
                   : "the same");
    const auto camera = ScriptedCamera::Make();
    camera->SetSerial(swap.serial);
    const auto device = MakeReconnectingDevice(
        camera->OpenDriver(), {.where_it_was = [camera](const DeviceInfo&) { return camera->OpenDriver(); },
                               .elsewhere = nullptr,
                               .patience_s = 60});
    device->Start();
    const auto next = [&]() -> std::optional<Frame> {
      for (const auto until = Clock::now() + 20s; Clock::now() < until;)
        if (auto frame = device->Next(20ms)) return frame;
      return std::nullopt;
    };
    double last_s = 0;
    const auto wait_until_gone = [&] {
      for (const auto until = Clock::now() + 20s;
           Clock::now() < until && device->State() == DeviceState::kStreaming;)
        if (const auto frame = device->Next(10ms)) last_s = frame->device_time_s;
      ASSERT_NE(device->State(), DeviceState::kStreaming);
    };
    ASSERT_TRUE(next());
    for (const bool clock_set_back : {false, true})
      for (int i = 0; i < (swap.other ? 1 : 3); ++i) {
        const auto frame = next();
        ASSERT_TRUE(frame);
        last_s = frame->device_time_s;
        camera->Unplug();
        wait_until_gone();
        if (clock_set_back) ShiftHostClock(-3600.0 * (i + 1));
        if (swap.other) {
          camera->SetMakerAndModel(swap.other->maker, swap.other->model);
          camera->SetSerial(swap.other->serial);
          camera->PlugIn();
          const int openings = camera->Openings();
          for (const auto until = Clock::now() + 20s;
               Clock::now() < until && camera->Openings() < openings + 2;)
            EXPECT_FALSE(device->Next(20ms)) << "a frame of another camera: " << which;
          ++refused;
          camera->SetMakerAndModel("test", "scripted");
          camera->SetSerial(swap.serial);
        }
        const auto in_again = Clock::now();
        camera->PlugIn({}, i == 1);  // once switched off: its clock begins anew
        const auto back = next();
        ASSERT_TRUE(back);
        longest_s = std::max(longest_s, SecondsSince(in_again));
        backward += back->device_time_s <= last_s;
        EXPECT_LT(back->device_time_s - last_s, 30) << "an hour is no gap";
        ++tried;
      }
    ShiftHostClock(0);
    device->Stop();
  }
  EXPECT_EQ(backward, 0) << "times go on";
  PrintFaultRow("camera lost and back, half of the times with the computer's clock set back", tried,
                fmt::format("the frames meanwhile; {} times ran backward", backward), longest_s);
  PrintFaultRow("camera lost, another one in its place (serial number, maker or model), then the right one",
                refused, "no frame of the other is taken", longest_s);
}

// Every third frame has pixels missing: it is no view, and no other is the worse for it.
TEST(CaptureFaults, ACorruptPayloadSpoilsNoView) {
  const ScratchFolder scratch;
  Capture(scratch / "whole", Arc(30));
  const auto whole = Photographs(scratch / "whole");
  auto shots = Arc(30);
  int corrupt = 0;
  for (std::size_t i = 2; i < shots.size(); i += 3, ++corrupt) shots[i].fault = Fault::kIncomplete;
  const Captured captured = Capture(scratch / "lf", shots);
  EXPECT_EQ(captured.light_field.views.size(), 30u - static_cast<std::size_t>(corrupt));
  std::set<std::string> known;
  for (const auto& [id, bytes] : whole) known.insert(bytes);
  int spoilt = 0;
  for (const auto& [id, bytes] : Photographs(scratch / "lf")) spoilt += !known.contains(bytes);
  EXPECT_EQ(spoilt, 0);
  PrintFaultRow("corrupt payload: frames with pixels missing", corrupt,
                fmt::format("those frames, counted; {} views spoilt", spoilt), std::nullopt);
}

// ---- Another capture. ----

// Started at once, one of them gets the folder; the other says so, and takes nothing from it.
TEST(CaptureFaults, TheSecondCaptureOfAFolderIsRefused) {
  int tried = 0;
  for (int round = 0; round < 3; ++round) {
    const ScratchFolder scratch;
    const fs::path dir = scratch / "lf";
    const auto run = [&](int seed) {
      return RunUlf(fmt::format(
          "capture 'sim:studio?width=160&height=120&seed={}' -o {} --headless --no-geometry --poses "
          "known --subject 0,0,0.07,0.162 --frames 25",
          seed, dir.string()));
    };
    auto other = std::async(std::launch::async, run, 1);
    const CommandResult mine = run(2), theirs = other.get();
    ++tried;
    const bool i_won = mine.exit_code == 0;
    EXPECT_NE(i_won, theirs.exit_code == 0) << mine.errors << theirs.errors;
    const std::string& refusal = i_won ? theirs.errors : mine.errors;
    EXPECT_TRUE(refusal.find("another process is recording") != std::string::npos ||
                refusal.find("--resume") != std::string::npos ||
                refusal.find("not empty") != std::string::npos)
        << refusal;
    const LightField light_field = ReadLightField(dir);
    EXPECT_EQ(light_field.device_serial, i_won ? "sim-studio-2" : "sim-studio-1");
    EXPECT_GT(light_field.views.size(), 1u);
    EXPECT_TRUE(light_field.doubts.empty());
    Photographs(dir);
  }
  PrintFaultRow("two captures into one folder, started at once", tried, "0 views; the second is refused",
                std::nullopt);
}

}  // namespace
}  // namespace ulf::test::capture_faults_test
