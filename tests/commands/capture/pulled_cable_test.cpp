// Tests: commands/capture/capture_command.
//
// The whole program against a camera whose cable is pulled and put back: the capture goes on.
#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/simulator/gige/simulated_gige_camera.h"
#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::test::pulled_cable_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using ::testing::HasSubstr;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::size_t ViewsIn(const fs::path& dir) {
  std::error_code missing;
  if (!fs::exists(dir / "journal.jsonl", missing)) return 0;
  const std::string journal = ReadWholeFile(dir / "journal.jsonl");
  std::size_t views = 0;
  for (std::size_t at = 0; (at = journal.find("\"event\":\"view\"", at)) != std::string::npos; ++at) ++views;
  return views;
}

bool WaitForViews(const fs::path& dir, std::size_t count, double at_most_s) {
  for (const auto start = Clock::now(); SecondsSince(start) < kPatience * at_most_s;
       std::this_thread::sleep_for(20ms))
    if (ViewsIn(dir) >= count) return true;
  return false;
}

// Whose clock the views are timed by, where it changes: true for a shared one.
std::vector<bool> ClockChanges(const fs::path& dir) {
  std::vector<bool> changes;
  for (const View& view : ReadLightField(dir).views)
    if (changes.empty() || changes.back() != view.on_shared_clock) changes.push_back(view.on_shared_clock);
  return changes;
}

// Frames that were taken before a change are recorded after it is told, as many as the program is behind.
bool WaitForClockChanges(const fs::path& dir, std::size_t count) {
  for (const auto start = Clock::now(); SecondsSince(start) < kPatience * 60;
       std::this_thread::sleep_for(100ms))
    if (ClockChanges(dir).size() >= count) return true;
  return false;
}

class PulledCable : public ::testing::Test {
 protected:
  void SetUp() override {
    static const std::optional<std::string> why_not = EnterLoopbackNamespace();
    if (why_not) GTEST_SKIP() << *why_not;
    GigeServerOptions options;
    options.simulation.width = 256;
    options.simulation.height = 192;
    options.simulation.fps = 10;
    options.simulation.faults.Add("freeze=0:0");  // the relay, for us to break
    camera_ = std::make_unique<SimulatedGigeCamera>(options);
    WriteCalibration(scratch_ / "camera.json", camera_->camera().camera(), options.serial, "exact");
  }

  std::unique_ptr<ChildProcess> StartCapture(const std::string& uri_options = "",
                                             const std::string& options = "--no-geometry") {
    return std::make_unique<ChildProcess>(
        std::vector<std::string>{"/bin/sh", "-c",
                                 "exec \"$ULF_BINARY\" capture 'aravis:127.0.0.1?" + uri_options + "' -o " +
                                     (scratch_ / "lf").string() + " --headless --json --calibration " +
                                     (scratch_ / "camera.json").string() + " " + options + " 2>&1"});
  }

  ScratchFolder scratch_;
  std::unique_ptr<SimulatedGigeCamera> camera_;
};

TEST_F(PulledCable, CaptureGoesOnSoonAndLosesNothing) {
  const fs::path dir = scratch_ / "lf";
  const auto capture = StartCapture("", "");  // with geometry, as usual
  ASSERT_TRUE(WaitForViews(dir, 3, 60)) << capture->ReadUntil("nothing of the kind", 1);
  camera_->relay()->Pull();
  EXPECT_THAT(capture->ReadUntil("tries to open", 15), HasSubstr("tries to open it again"));
  const std::size_t views_before = ViewsIn(dir);
  const std::string journal_before = ReadWholeFile(dir / "journal.jsonl");
  std::this_thread::sleep_for(2s);
  camera_->relay()->PutBack();
  const auto back = Clock::now();
  EXPECT_THAT(capture->ReadUntil("streams again", 30), HasSubstr("streams again"));
  const double restored_s = SecondsSince(back);
  RecordProperty("restored_ms", static_cast<int>(1000 * restored_s));
  EXPECT_LE(restored_s, 3 * kPatience);
  EXPECT_TRUE(WaitForViews(dir, views_before + 2, 60)) << "the tracker found itself and records";
  capture->Signal(SIGINT);
  const std::string rest = capture->ReadUntil("stopped_because", 30);
  EXPECT_EQ(capture->Wait(30), 0);

  const std::size_t json_begin = rest.rfind("\n{");
  const auto report = JsonFromText(rest.substr(json_begin == std::string::npos ? 0 : json_begin + 1));
  EXPECT_EQ(report["device"]["reconnects"], 1);
  EXPECT_EQ(report["events"]["restored"], 1);
  EXPECT_EQ(ReadWholeFile(dir / "journal.jsonl").substr(0, journal_before.size()), journal_before);
  const LightField light_field = ReadLightField(dir);
  EXPECT_GE(light_field.views.size(), views_before + 2);
  double last_s = -1e300;
  for (const View& view : light_field.views) {
    EXPECT_NO_THROW(ReadViewImage(light_field, view)) << view.id;
    EXPECT_GT(view.device_time_s, last_s);
    last_s = view.device_time_s;
  }
  std::ifstream journal(dir / "journal.jsonl");
  double gap_s = 0;
  for (std::string line; std::getline(journal, line);) {
    const auto event = JsonFromText(line);
    if (event["event"] == "gap" && event["reason"].get<std::string>().starts_with("device: "))
      gap_s = event["to_s"].get<double>() - event["from_s"].get<double>();
  }
  EXPECT_GT(gap_s, 2) << "as long as the cable was out, and in the journal";
}

TEST_F(PulledCable, LostClockMasterIsToldNotClaimed) {
  const fs::path dir = scratch_ / "lf";
  const auto capture = StartCapture("ptp=on");
  ASSERT_TRUE(WaitForViews(dir, 2, 60)) << capture->ReadUntil("nothing of the kind", 1);
  camera_->HearMaster(false);
  EXPECT_THAT(capture->ReadUntil("no longer follows", 30), HasSubstr("no longer follows its IEEE 1588"));
  EXPECT_TRUE(WaitForClockChanges(dir, 2));
  camera_->HearMaster(true);
  EXPECT_THAT(capture->ReadUntil("clock again", 30), HasSubstr("follows an IEEE 1588 clock again"));
  EXPECT_TRUE(WaitForClockChanges(dir, 3));
  capture->Signal(SIGINT);
  EXPECT_THAT(capture->ReadUntil("stopped_because", 30), HasSubstr("\"notice\""));
  EXPECT_EQ(capture->Wait(30), 0);
  EXPECT_THAT(ClockChanges(dir), ::testing::ElementsAre(true, false, true));
}

// The thread of the camera library that receives the stream.
pid_t LibrarysThread(pid_t process) {
  for (const auto& task : fs::directory_iterator("/proc/" + std::to_string(process) + "/task"))
    if (ReadWholeFile(task.path() / "comm") == "arv_gv_stream\n") return std::stoi(task.path().filename());
  return 0;
}

TEST_F(PulledCable, DyingLibraryClosesTheLightField) {
  if (kIsSanitized) GTEST_SKIP() << "the sanitizer handles the signal";
  const fs::path dir = scratch_ / "lf";
  const auto capture = StartCapture("", "");  // with geometry, as usual
  ASSERT_TRUE(WaitForViews(dir, 2, 60));
  const pid_t thread = LibrarysThread(capture->Pid());
  ASSERT_NE(thread, 0);
  tgkill(capture->Pid(), thread, SIGSEGV);
  EXPECT_THAT(capture->ReadUntil("--resume", 30),
              ::testing::AllOf(HasSubstr("died of signal 11"), HasSubstr("in its thread 'arv_gv_stream'"),
                               HasSubstr("is closed with ")));
  EXPECT_EQ(capture->Wait(30), 1);
  EXPECT_GE(ReadLightField(dir).views.size(), 2u);
  EXPECT_TRUE(fs::exists(dir / "transforms.json"));
  EXPECT_THAT(ReadWholeFile(dir / "journal.jsonl"), HasSubstr("\"event\":\"close\""));
}

TEST_F(PulledCable, NextProgramReopensACrashedOnesCamera) {
  auto capture = StartCapture();
  ASSERT_TRUE(WaitForViews(scratch_ / "lf", 1, 60));
  capture->Kill();
  const CommandResult next = RunUlf("record aravis:127.0.0.1 --frames 3 -o " + (scratch_ / "next").string());
  EXPECT_EQ(next.exit_code, 0) << next.errors;  // it waited, unless it took long to start
}

TEST_F(PulledCable, AStopWhileItIsOutClosesTheLightField) {
  const fs::path dir = scratch_ / "lf";
  const auto capture = StartCapture();
  ASSERT_TRUE(WaitForViews(dir, 2, 60));
  camera_->relay()->Pull();
  EXPECT_THAT(capture->ReadUntil("tries to open", 15), HasSubstr("tries to open it again"));
  capture->Signal(SIGINT);
  EXPECT_THAT(capture->ReadUntil("stopped_because", 40), HasSubstr("\"signal\""));
  EXPECT_EQ(capture->Wait(30), 0);
  EXPECT_GE(ReadLightField(dir).views.size(), 2u);
  EXPECT_TRUE(fs::exists(dir / "transforms.json"));
}

TEST_F(PulledCable, FinalLossClosesTheLightField) {
  const fs::path dir = scratch_ / "lf";
  const auto capture = StartCapture("reconnect_s=1");
  ASSERT_TRUE(WaitForViews(dir, 2, 60));
  camera_->relay()->Pull();
  EXPECT_THAT(capture->ReadUntil("stopped_because", 40), HasSubstr("device_lost"));
  EXPECT_EQ(capture->Wait(30), 1);
  EXPECT_GE(ReadLightField(dir).views.size(), 2u);
}

}  // namespace
}  // namespace ulf::test::pulled_cable_test
