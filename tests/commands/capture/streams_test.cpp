// Tests: commands/capture/capture_command, commands/capture/crash_handler, commands/standard_streams,
// core/base/stop_signal, main.
//
// Commands whose standard streams cannot be written, and whose terminal goes away: what they work for is done
// all the same, and a report that is lost is said. Rows of docs/measured/cameras.md.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "core/base/atomic_file.h"
#include "core/base/host_time.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/child_process.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::test::streams_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kCapture =
    "capture 'sim:studio?width=160&height=120&seed=1&speed_deg_s=60&look_away=0' --headless --no-geometry "
    "--poses known "
    "--subject 0,0,0.07,0.162";

std::string Ulf() {
  const char* const binary = std::getenv("ULF_BINARY");
  return binary ? binary : "false";
}

// Its exit status, wherever a pipe leads. `streams`: redirections, and what reads.
int ExitOf(const std::string& arguments, const std::string& streams, const fs::path& scratch) {
  const std::string status = (scratch / "status").string();
  const std::string line = fmt::format("{{ {} {}; echo $? >{}; }} {}", Ulf(), arguments, status, streams);
  EXPECT_EQ(std::system(line.c_str()), 0) << line;
  return std::atoi(ReadWholeFile(status).c_str());
}

bool IsClosed(const fs::path& dir) {
  return ReadWholeFile(dir / "journal.jsonl").find("\"event\":\"close\"") != std::string::npos;
}

void WaitForJournal(const fs::path& dir, std::size_t bytes) {
  const auto begin = std::chrono::steady_clock::now();
  std::error_code missing;
  while (fs::file_size(dir / "journal.jsonl", missing) < bytes || missing) {
    ASSERT_LT(SecondsSince(begin), 60 * kPatience);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

// ---- Streams that cannot be written. ----

TEST(Streams, ACaptureGoesOnWhateverBecomesOfThem) {
  struct Case {
    const char *what, *streams;
    int exit_code;
  };
  const std::vector<Case> cases{
      {"standard error on a full disk", ">/dev/null 2>/dev/full", 0},
      {"standard error closed", ">/dev/null 2>&-", 0},
      {"all three closed", "<&- >&- 2>&-", 1},
      {"standard output on a full disk", ">/dev/full 2>/dev/null", 1},
      {"a reader of both that leaves at the first byte (`head`, `tee`, a connection)",
       "2>&1 | head -c 1 >/dev/null", 1},
  };
  const ScratchFolder scratch;
  const std::string frames = " --frames 40 -o ";
  ASSERT_EQ(ExitOf(kCapture + frames + (scratch / "whole").string(), ">/dev/null 2>&1", scratch.path()), 0);
  const std::size_t views = ReadLightField(scratch / "whole").views.size();
  ASSERT_GT(views, 20u);
  int lost = 0;
  for (const Case& each : cases) {
    const fs::path dir = scratch / fmt::format("lf{}", &each - cases.data());
    EXPECT_EQ(ExitOf(kCapture + frames + dir.string(), each.streams, scratch.path()), each.exit_code)
        << each.what;
    const LightField light_field = ReadLightField(dir);
    lost += static_cast<int>(views) - static_cast<int>(light_field.views.size());
    EXPECT_EQ(light_field.views.size(), views) << each.what;
    EXPECT_TRUE(light_field.doubts.empty()) << each.what;
    EXPECT_TRUE(IsClosed(dir)) << each.what;
  }
  PrintFaultRow("standard streams of a capture: on a full disk, closed, their reader gone",
                static_cast<int>(cases.size()),
                fmt::format("{} views; a report that could not be written is said", lost), std::nullopt);
}

TEST(Streams, AReportThatIsLostIsAnError) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string(), set = (scratch / "set").string();
  WriteSample(dir, 3);
  const std::vector<std::string> commands{"info " + dir,
                                          "info --json " + dir,
                                          "plan --focal-px 1200 --width 1280 --distance 1 --radius 0.15",
                                          "--help",
                                          "capture --help",
                                          "--version",
                                          "completion bash",
                                          "repair " + dir,
                                          "export nerfstudio --known-points " + dir + " -o " + set,
                                          "take-back " + dir + " 1"};
  for (const std::string& command : commands)
    for (const auto& [stream, why] :
         {std::pair{"/dev/full", "No space left on device"}, {"&-", "Bad file descriptor"}}) {
      const CommandResult result = RunUlf(command + " >" + stream);
      fs::remove_all(set);
      if (command.starts_with("take-back") && stream[0] == '&') continue;  // it has been taken back already
      EXPECT_EQ(result.exit_code, 1) << command;
      EXPECT_THAT(result.errors, AllOf(HasSubstr("ulf: standard output: the report could not be written: "),
                                       HasSubstr(why), HasSubstr("all else that was asked is done")))
          << command;
    }
  EXPECT_EQ(ReadLightField(dir).views.size(), 2u) << "it was taken back all the same";
}

TEST(Streams, AnErrorKeepsItsExitStatus) {
  EXPECT_EQ(RunUlf("info /nowhere >/dev/full").exit_code, 1);
  const ScratchFolder scratch;
  EXPECT_EQ(ExitOf("info --nonsense", ">/dev/full 2>/dev/full", scratch.path()), 2);
}

// ---- A terminal that goes away. ----

// `ulf` in a session of its own on a new terminal, whose other end is `*master`.
pid_t OnTerminal(const std::string& arguments, int* master) {
  const std::string line = "exec " + Ulf() + " " + arguments;
  const pid_t child = forkpty(master, nullptr, nullptr, nullptr);
  if (child == 0) {
    execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    _exit(127);
  }
  return child;
}

int ExitStatusOf(pid_t child) {
  const auto begin = std::chrono::steady_clock::now();
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (SecondsSince(begin) > 60 * kPatience) kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST(Streams, ATerminalThatDiesEndsACaptureInGoodOrder) {
  constexpr int kTimes = 3;
  int unclosed = 0;
  for (int i = 0; i < kTimes; ++i) {
    const ScratchFolder scratch;
    const fs::path dir = scratch / "lf";
    int master = -1;
    const pid_t capture = OnTerminal(std::string(kCapture) + " -o " + dir.string(), &master);
    WaitForJournal(dir, 3000 + 1000 * static_cast<std::size_t>(i));
    close(master);
    EXPECT_EQ(ExitStatusOf(capture), 1) << "nobody has read its report";
    unclosed += !IsClosed(dir);
    const LightField light_field = ReadLightField(dir);
    EXPECT_GT(light_field.views.size(), 2u);
    EXPECT_TRUE(light_field.doubts.empty());
  }
  EXPECT_EQ(unclosed, 0);
  PrintFaultRow("the terminal or the connection of a capture dies (SIGHUP, then EIO)", kTimes,
                "0 views; the light field is closed as by Ctrl-C", std::nullopt);
}

TEST(Streams, ATerminalThatStandsStillHoldsNothingUp) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  int master = -1, terminal = -1;
  ASSERT_EQ(openpty(&master, &terminal, nullptr, nullptr, nullptr), 0);
  ASSERT_EQ(tcflow(terminal, TCOOFF), 0);  // as Ctrl-S does
  const pid_t capture = fork();
  if (capture == 0) {
    dup2(open("/dev/null", O_WRONLY), STDOUT_FILENO);
    dup2(terminal, STDERR_FILENO);
    const std::string line = "exec " + Ulf() + " " + kCapture + " --frames 40 -o " + dir.string();
    execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    _exit(127);
  }
  EXPECT_EQ(ExitStatusOf(capture), 0);
  EXPECT_TRUE(IsClosed(dir));
  close(master), close(terminal);
  PrintFaultRow("the terminal of a capture stands still (Ctrl-S, a connection that does not answer)", 1,
                "0 views", std::nullopt);
}

TEST(Streams, ACrashClosesWhereNobodyReads) {
  if (kIsSanitized) GTEST_SKIP() << "the sanitizer has its own word to say";
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ChildProcess capture(
      {"/bin/sh", "-c", fmt::format("exec {} {} -o {} 2>/dev/full", Ulf(), kCapture, dir.string())});
  WaitForJournal(dir, 3000);
  capture.Signal(SIGABRT);
  EXPECT_EQ(capture.Wait(60), 1);
  EXPECT_TRUE(IsClosed(dir));
}

TEST(Streams, AHangupThatWasIgnoredStaysIgnored) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ChildProcess capture(
      {"/bin/sh", "-c",
       fmt::format("trap '' HUP; exec {} {} --frames 60 -o {} 2>/dev/null", Ulf(), kCapture, dir.string())});
  WaitForJournal(dir, 1000);
  capture.Signal(SIGHUP);
  EXPECT_EQ(capture.Wait(60), 0);
  EXPECT_THAT(ReadWholeFile(dir / "journal.jsonl"), Not(HasSubstr("signal")));
  EXPECT_GT(ReadLightField(dir).views.size(), 5u);
}

TEST(Streams, AHangupEndsARecordingInGoodOrder) {
  const ScratchFolder scratch;
  const fs::path frames = scratch / "frames";
  ChildProcess record({Ulf(), "record", "sim:studio?width=160&height=120", "-o", frames.string()});
  const auto begin = std::chrono::steady_clock::now();
  while (!fs::exists(frames / "frames") || std::distance(fs::directory_iterator(frames / "frames"), {}) < 4) {
    ASSERT_LT(SecondsSince(begin), 60 * kPatience);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  record.Signal(SIGHUP);
  EXPECT_EQ(record.Wait(30), 0);
  EXPECT_THAT(record.ReadUntil("left out", 5), HasSubstr(frames.string()));
}

}  // namespace
}  // namespace ulf::test::streams_test
