// Tests: coverage/session/capture_session, coverage/session/record/view_spool,
// core/light_field/folder/light_field_writer, core/light_field/folder/folder_repair.
//
// SIGKILL at every stage of a capture: rows of docs/measured/cameras.md.
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <climits>
#include <cstdlib>
#include <set>
#include <string_view>

#include "acquisition/simulator/simulated_device.h"
#include "core/base/host_time.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/repair_plan.h"
#include "tests/coverage/session/kept_views.h"
#include "tests/support/slow_disk.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test::capture_kills_test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using ::testing::HasSubstr;

bool InLongRun() {
  const char* const asked = std::getenv("ULF_STABILITY");
  return asked && std::string_view(asked) == "seeds";
}

// One child for each call that changes the disk, from the first file of the folder to the end of closing.
TEST(CaptureFaults, KilledBeforeEveryDiskChange) {
  const int step = InLongRun() ? 1 : 9;
  constexpr int kShots = 5;
  const ScratchFolder scratch;
  Capture(scratch / "whole", Arc(kShots));
  const auto whole = Photographs(scratch / "whole");
  ASSERT_EQ(whole.size(), static_cast<std::size_t>(kShots));
  auto* const accepted = static_cast<std::atomic<int>*>(
      mmap(nullptr, sizeof(std::atomic<int>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(accepted, MAP_FAILED);
  for (const bool threads : {false, true}) {
    int tried = 0, lost = 0, most_lost = 0, in_closing = 0;
    double longest_s = 0;
    for (int call = 1;; call += step) {
      const fs::path dir = scratch / fmt::format("killed_{}_{}", threads, call);
      *accepted = 0;
      const pid_t child = fork();
      if (child == 0) {
        CaptureHooks hooks;
        hooks.after_frame = [&](const SharedCaptureState& now) {
          *accepted = static_cast<int>(now->view_ids.size());
        };
        DieBeforeDiskCall(call);
        Capture(dir, Arc(kShots), threads ? InThreads() : Options(), {}, hooks);
        _exit(0);
      }
      int status = 0;
      waitpid(child, &status, 0);
      if (WIFEXITED(status)) break;
      ASSERT_EQ(WTERMSIG(status), SIGKILL) << "call " << call;
      ++tried;
      std::map<int, std::string> kept;
      if (fs::exists(dir / "journal.jsonl") && fs::file_size(dir / "journal.jsonl") > 0) {
        try {
          kept = Photographs(dir);
        } catch (const Error& error) {
          EXPECT_THAT(error.what(), HasSubstr("before it began")) << "call " << call;
        }
      }
      EXPECT_EQ(Lost(kept, whole), 0) << "call " << call << ": a view that is not what it was";
      const int missing = *accepted - static_cast<int>(kept.size());
      lost += std::max(0, missing);
      most_lost = std::max(most_lost, missing);
      in_closing += *accepted == kShots;
      if (!threads) {
        EXPECT_LE(missing, 0) << "call " << call;
      }
      const auto again = Clock::now();
      const Captured resumed = GoOn(dir);
      longest_s = std::max(longest_s, SecondsSince(again));
      EXPECT_EQ(Lost(kept, Photographs(dir)), 0) << "call " << call << ": after going on";
      EXPECT_GT(resumed.light_field.views.size(), kept.size()) << "call " << call;
      fs::remove_all(dir);
    }
    EXPECT_LE(most_lost, static_cast<int>(CaptureOptions{}.spool_views));
    EXPECT_GT(in_closing, 0) << "it was never killed while closing";
    EXPECT_GT(tried, 40 / step);
    PrintFaultRow(
        fmt::format("SIGKILL before each call that changes the disk, {}",
                    threads ? "writing in threads" : "writing in the capture's own thread"),
        tried,
        fmt::format("{} views of those under way, {} at most in one kill", lost, std::max(0, most_lost)),
        longest_s);
  }
  munmap(accepted, sizeof(std::atomic<int>));
}

// ---- What else writes. ----

// What a process said before it died.
struct Said {
  std::atomic<int> disk_calls;  // of one that was left alive
  std::atomic<int> count;       // of views that are in the light field
  std::array<int, 64> ids;
  void Record(const CaptureState& now) {
    for (std::size_t i = 0; i < std::min(now.view_ids.size(), ids.size()); ++i) ids[i] = now.view_ids[i];
    count = static_cast<int>(std::min(now.view_ids.size(), ids.size()));
  }
};

struct Stage {
  const char* name;
  std::function<void(const fs::path& dir)> before;  // what is there when it begins; empty: nothing
  // Ends by itself, or goes on with what a killed one left.
  std::function<void(const fs::path& dir, Said& said)> work;
  std::set<int> taken_back = {};  // views that it moves to unposed/
};

CaptureHooks Telling(Said& said) {
  CaptureHooks hooks;
  hooks.after_frame = [&said](const SharedCaptureState& now) { said.Record(*now); };
  return hooks;
}

LightFieldWriter WriterOf(const fs::path& dir, const CameraModel& camera) {
  try {
    ReadLightField(dir);
  } catch (const Error&) {  // nothing is there, or nothing had begun
    return NewWriter(dir, camera);
  }
  return LightFieldWriter::Resume(dir);
}

// 16 bits of linear light, for a master beside each photograph.
class DeepDevice : public PlanarDevice {
 public:
  using PlanarDevice::PlanarDevice;
  std::optional<Frame> Next(std::chrono::milliseconds timeout) override {
    auto frame = PlanarDevice::Next(timeout);
    if (!frame) return frame;
    frame->image.pixels.convertTo(frame->image.pixels, CV_16U, 257);
    frame->image.transfer = Transfer::kLinear;
    return frame;
  }
};

void Record(Device& device, const CameraModel& camera, const fs::path& dir, Said& said,
            CaptureOptions options = Options(), CaptureHooks hooks = {}) {
  if (!hooks.after_frame) hooks = Telling(said);
  const auto poses = MakeKnownPoseSource(camera, options.subject);
  device.Start();
  RunCapture(device, camera, *poses, WriterOf(dir, camera), options, hooks);
}

std::vector<PlanarShot> Shots(std::size_t first, std::size_t end) {
  const auto all = Arc(static_cast<int>(end));
  return {all.begin() + static_cast<std::ptrdiff_t>(first), all.end()};
}

std::vector<Stage> Stages() {
  const auto four_views = [](const fs::path& dir) { Capture(dir, Shots(0, 4)); };
  std::vector<Stage> stages;
  stages.push_back({"a capture resumed", four_views, [](const fs::path& dir, Said& said) {
                      PlanarDevice device(Shots(4, 7));
                      Record(device, kCamera, dir, said);
                    }});
  stages.push_back({"a capture resumed under another lens", four_views, [](const fs::path& dir, Said& said) {
                      CameraModel other = kCamera;
                      other.fx *= 1.01;
                      LightFieldWriter writer = LightFieldWriter::Resume(dir);
                      if (writer.Contents().cameras.size() == 1) writer.AddCamera({other, {}, {}, "a file"});
                      PlanarDevice device(Shots(4, 7));
                      const auto poses = MakeKnownPoseSource(other, Options().subject);
                      device.Start();
                      RunCapture(device, other, *poses, std::move(writer), Options(), Telling(said));
                    }});
  stages.push_back({"masters of 16 bits", {}, [](const fs::path& dir, Said& said) {
                      DeepDevice device(Shots(0, 4));
                      Record(device, kCamera, dir, said);
                    }});
  stages.push_back(
      {"exposure brackets", {}, [](const fs::path& dir, Said& said) {
         const auto device = OpenSimulatedDevice(DeviceUri::Parse(
             "sim:studio?width=160&height=120&fps=10&speed_deg_s=30&look_away=0&exposure_us=2000&noise=0"));
         CaptureOptions options = Options();
         options.subject = Subject{{0, 0, 0.07}, 0.17};
         options.bracket = ExposureBracket::Parse("3x2EV");
         options.max_frames = 14;
         Record(*device, *device->Camera(), dir, said, options);
       }});
  stages.push_back({"views taken back",
                    [](const fs::path& dir) { Capture(dir, Shots(0, 6)); },
                    [](const fs::path& dir, Said& said) {
                      CaptureRequests requests;
                      CaptureHooks hooks = Telling(said);
                      hooks.requests = &requests;
                      requests.Push(TakeBackViews{{2, 3}});
                      requests.Push(TakeBackLast{});
                      PlanarDevice device(Shots(6, 8));
                      Record(device, kCamera, dir, said, Options(), hooks);
                    },
                    {2, 3, 6}});
  stages.push_back({"`ulf repair` of a journal that was cut",
                    [](const fs::path& dir) {
                      Capture(dir, Shots(0, 6));
                      fs::resize_file(dir / "journal.jsonl", fs::file_size(dir / "journal.jsonl") / 2);
                    },
                    [](const fs::path& dir, Said&) { Repair(dir); }});
  stages.push_back({"depth maps and mesh at the end", {}, [](const fs::path& dir, Said& said) {
                      CaptureOptions options = Options();
                      options.geometry = true;
                      PlanarDevice device(Shots(0, 8));
                      Record(device, kCamera, dir, said, options);
                    }});
  return stages;
}

// Forks: 0 where the child ended by itself, else the signal. `dies_before`: the call of the disk;
// INT_MAX: none.
int InChild(const Stage& stage, const fs::path& dir, int dies_before, Said& said) {
  said.count = 0;
  const pid_t child = fork();
  if (child == 0) {
    DieBeforeDiskCall(dies_before);
    stage.work(dir, said);
    said.disk_calls = dies_before - DiskCallsLeft();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 0) << stage.name;
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

// Bytes of all files of the folder. A view that is taken back leaves the journal first; killed there, its
// photograph still lies where it was, and nothing is written over it.
std::set<std::string> AllFiles(const fs::path& dir) {
  std::set<std::string> bytes;
  for (const auto& file : fs::recursive_directory_iterator(dir))
    if (file.is_regular_file()) bytes.insert(ReadWholeFile(file.path()));
  return bytes;
}

TEST(CaptureFaults, KilledWhateverItWrites) {
  cv::setNumThreads(1);  // a child of a process with threads has none of them
  auto* const said = static_cast<Said*>(
      mmap(nullptr, sizeof(Said), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(said, MAP_FAILED);
  for (const Stage& stage : Stages()) {
    const ScratchFolder scratch;
    const fs::path start = scratch / "start", whole = scratch / "whole", dir = scratch / "killed";
    const auto begin = [&](const fs::path& at) {
      fs::remove_all(at);
      if (stage.before) fs::copy(start, at, fs::copy_options::recursive);
    };
    if (stage.before) stage.before(start);
    // Twice: the first run may also write what the simulator keeps of its scene, which the killed
    // ones find there.
    for (int run = 0; run < 2; ++run) {
      begin(whole);
      ASSERT_EQ(InChild(stage, whole, INT_MAX, *said), 0) << stage.name;
    }
    const int calls = said->disk_calls;
    ASSERT_GT(calls, 3) << stage.name;
    auto truth = Photographs(whole);
    if (stage.before) {
      // Of what was there, also what the stage takes out of it.
      const LightField before = ReadLightField(start);
      for (const View& view : before.views) truth.emplace(view.id, ReadWholeFile(start / view.image_path));
    }
    std::map<int, std::string> had;
    if (stage.before) had = Photographs(start);
    // Every call in the long run, two each day.
    const int first = InLongRun() ? 1 : calls / 3, step = InLongRun() ? 1 : std::max(1, calls / 2);
    int tried = 0, lost = 0;
    double longest_s = 0;
    for (int call = first; call <= calls; call += step) {
      begin(dir);
      const int signal = InChild(stage, dir, call, *said);
      if (signal == 0 && 10 * call > 9 * calls) break;  // threads may need a few calls fewer
      ASSERT_EQ(signal, SIGKILL) << stage.name << ", call " << call << " of " << calls;
      ++tried;
      std::set<int> promised(said->ids.begin(), said->ids.begin() + said->count);
      for (const auto& [id, bytes] : had) promised.insert(id);
      const std::string at = fmt::format("{}, killed before call {} of {}", stage.name, call, calls);
      const auto check = [&](const std::map<int, std::string>& now, const std::set<int>& may_be_taken_back) {
        const std::set<std::string> files = AllFiles(dir);
        for (const int id : promised) {
          const bool there = now.contains(id) && now.at(id) == truth.at(id);
          const bool taken_back = may_be_taken_back.contains(id) && files.contains(truth.at(id));
          lost += !there && !taken_back;
          EXPECT_TRUE(there || taken_back) << at << ": view " << id;
        }
      };
      const bool has_begun = fs::exists(dir / "journal.jsonl") && fs::file_size(dir / "journal.jsonl") > 0;
      std::map<int, std::string> kept;
      try {
        kept = Photographs(dir);
        const CommandResult info = RunUlf("info " + dir.string());
        EXPECT_EQ(info.exit_code, 0) << at << info.errors;
      } catch (const Error& error) {
        EXPECT_TRUE(!has_begun || std::string(error.what()).find("before it began") != std::string::npos)
            << at << ": " << error.what();
      }
      check(kept, stage.taken_back);
      const auto again = Clock::now();
      EXPECT_EQ(InChild(stage, dir, INT_MAX, *said), 0) << at << ": the next run";
      longest_s = std::max(longest_s, SecondsSince(again));
      // It takes back the last one, whichever that is now.
      check(Photographs(dir), stage.taken_back.empty() ? std::set<int>{} : promised);
      EXPECT_GE(Photographs(dir).size() + (stage.taken_back.empty() ? 0 : 2 * stage.taken_back.size()),
                truth.size())
          << at;
    }
    EXPECT_EQ(lost, 0) << stage.name;
    PrintFaultRow(fmt::format("SIGKILL before each call that changes the disk: {}", stage.name), tried,
                  fmt::format("{} views that were said to be recorded", lost), longest_s);
  }
  munmap(said, sizeof(Said));
}

}  // namespace
}  // namespace ulf::test::capture_kills_test
