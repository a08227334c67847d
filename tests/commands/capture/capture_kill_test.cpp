// Tests: commands/capture/capture_command, commands/capture/crash_handler.
//
// Whole captures, killed, interrupted or broken as processes: what was recorded is there, and the capture
// goes on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fcntl.h>
#include <cstdlib>
#include <random>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::capture_kill_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSubject = "0,0,0.07,0.162";  // the studio's

// `ulf capture` of the simulated camera with the poses it brings, as fast as it goes.
pid_t StartCapture(const fs::path& dir, int seed, const fs::path& errors = "/dev/null") {
  const pid_t child = fork();
  if (child != 0) return child;
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(open(errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644), STDERR_FILENO);
  const char* binary = std::getenv("ULF_BINARY");
  const std::string uri = "sim:studio?width=320&height=240&seed=" + std::to_string(seed);
  execl(binary, binary, "capture", uri.c_str(), "-o", dir.c_str(), "--headless", "--poses", "known",
        "--subject", kSubject, nullptr);
  _exit(127);
}

bool WaitForViews(const fs::path& dir, std::size_t bytes) {
  for (int i = 0; i < 20000 * test::kPatience; ++i) {
    std::error_code missing;
    if (fs::file_size(dir / "journal.jsonl", missing) > bytes && !missing) return true;
    usleep(1000);
  }
  return false;
}

TEST(CaptureProcess, SurvivesSigkillAtRandomMoments) {
  test::ScratchFolder scratch;
  std::mt19937 random(7);
  std::size_t total = 0;
  for (int round = 0; round < KILLS; ++round) {
    const fs::path dir = scratch / ("lf" + std::to_string(round));
    const pid_t child = StartCapture(dir, round + 1);
    // Moments by what is recorded, not by the clock: a busy machine records little in a second.
    const std::size_t bytes = std::uniform_int_distribution<std::size_t>(0, 8000)(random);
    ASSERT_TRUE(WaitForViews(dir, bytes))
        << "round " << round << ": the capture stood still before " << bytes << " bytes of journal";
    usleep(std::uniform_int_distribution<useconds_t>(0, 30000)(random));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "round " << round << ": it ended by itself";

    const LightField killed = ReadLightField(dir);
    for (const View& view : killed.views) {
      EXPECT_NO_THROW(ReadViewImage(killed, view)) << "round " << round << ", view " << view.id;
      if (!view.master_path.empty()) {
        EXPECT_NO_THROW(ReadImageFile((dir / view.master_path).string()))
            << "round " << round << ", view " << view.id;
      }
    }
    total += killed.views.size();
    // The counts of its frames died with it, which is said.
    if (!killed.views.empty()) {
      EXPECT_THAT(test::RunUlf("info " + dir.string()).output,
                  testing::HasSubstr(fmt::format("was not closed (killed, or still running): {} of it",
                                                 Counted(killed.views.size(), "view"))));
    }
  }
  EXPECT_GT(total, 2u * KILLS) << "the kills came before anything was recorded: the test shows nothing";
}

TEST(CaptureProcess, CrashClosesAndNamesTheLightField) {
  if (test::kIsSanitized) GTEST_SKIP() << "the sanitizer has its own word to say";
  test::ScratchFolder scratch;
  const fs::path dir = scratch / "lf", errors = scratch / "errors";
  const pid_t child = StartCapture(dir, 3, errors);
  ASSERT_TRUE(WaitForViews(dir, 1500));
  kill(child, SIGABRT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status)) << "it died all the same";
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_THAT(ReadWholeFile(errors), testing::AllOf(testing::HasSubstr("died of signal 6 (Aborted)"),
                                                    testing::HasSubstr(dir.string() + " is closed with "),
                                                    testing::HasSubstr("--resume")));
  EXPECT_THAT(ReadWholeFile(dir / "journal.jsonl"), testing::HasSubstr("\"event\":\"close\""));
  EXPECT_TRUE(fs::exists(dir / "transforms.json"));
  const LightField closed = ReadLightField(dir);
  EXPECT_GT(closed.views.size(), 1u);
  for (const View& view : closed.views) EXPECT_NO_THROW(ReadViewImage(closed, view)) << view.id;
  const auto resumed = test::RunUlf("capture --no-geometry 'sim:studio?width=320&height=240&seed=3' -o " +
                                    dir.string() + " --headless --poses known --resume --frames 10");
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  const std::size_t views = ReadLightField(dir).views.size();
  EXPECT_GE(views, closed.views.size());
  EXPECT_THAT(
      test::RunUlf("info " + dir.string()).output,
      testing::HasSubstr(fmt::format("still running): {} of it", Counted(closed.views.size(), "view"))));
}

TEST(CaptureProcess, StackOverflowClosesTheLightField) {
  if (test::kIsSanitized) GTEST_SKIP() << "the sanitizer has its own word to say";
  for (const auto& [where, name] : {std::pair{"main", "overrun_capture"}, {"other", "overrun"}}) {
    test::ScratchFolder scratch;
    const fs::path dir = scratch / "lf", errors = scratch / "errors";
    WriteSample(dir, 2);
    const int status =
        std::system((OVERRUN_CAPTURE " " + dir.string() + " " + where + " 2>" + errors.string()).c_str());
    ASSERT_TRUE(WIFEXITED(status)) << where;
    EXPECT_EQ(WEXITSTATUS(status), 1) << where;
    EXPECT_THAT(ReadWholeFile(errors),
                testing::AllOf(testing::HasSubstr("died of signal 11"),
                               testing::HasSubstr(std::string("in its thread '") + name + "'"),
                               testing::HasSubstr("is closed with 2 views")))
        << where;
  }
}

TEST(CaptureProcess, SigintClosesAndResumeGoesOn) {
  test::ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  const pid_t child = StartCapture(dir, 3);
  ASSERT_TRUE(WaitForViews(dir, 2000));
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const LightField stopped = ReadLightField(dir);
  EXPECT_GT(stopped.views.size(), 1u);
  EXPECT_TRUE(stopped.subject);
  EXPECT_GT(stopped.capture_s, 0);
  EXPECT_TRUE(fs::exists(dir / "transforms.json"));
  EXPECT_TRUE(fs::exists(dir / "sparse/0/images.txt"));

  const auto resumed = test::RunUlf("capture --no-geometry 'sim:studio?width=320&height=240&seed=3' -o " +
                                    dir.string() + " --headless --poses known --resume --frames 200");
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_GE(ReadLightField(dir).views.size(), stopped.views.size()) << "what was recorded stays";
  const auto other = test::RunUlf("capture --no-geometry 'sim:studio?width=320&height=240&seed=4' -o " +
                                  dir.string() + " --headless --poses known --resume --frames 5");
  EXPECT_EQ(other.exit_code, 1) << "another camera does not go on with this one's light field";
  EXPECT_THAT(other.errors,
              testing::AllOf(testing::HasSubstr("sim-studio-3"), testing::HasSubstr("sim-studio-4")));
  EXPECT_NE(test::RunUlf("capture --no-geometry sim:studio -o " + dir.string() +
                         " --headless --poses known --frames 5")
                .exit_code,
            0)
      << "a new capture does not write into an old one";
}

}  // namespace
}  // namespace ulf::capture_kill_test
