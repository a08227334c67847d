// ulf track as a process: told to stop, it writes what it has.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "acquisition/atomic_file.h"
#include "tests/support/test_paths.h"
#include "tracking/trajectory.h"

namespace ulf {
namespace {

TEST(TrackCommand, SigintWritesThePosesSoFar) {
  test::ScratchFolder scratch;
  const std::string poses = (scratch / "poses.txt").string(), log = (scratch / "log").string();
  const pid_t child = fork();
  if (child == 0) {
    const int file = open(log.c_str(), O_WRONLY | O_CREAT, 0644);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    const char* binary = std::getenv("ULF_BINARY");
    execl(binary, binary, "track", "sim:studio?width=320&height=240&duration_s=600", "-o", poses.c_str(),
          nullptr);
    _exit(127);
  }
  // Progress lines come every two seconds: the second one is well after the start.
  for (int i = 0; i < 600; ++i) {
    usleep(100000);
    const std::string said = std::filesystem::exists(log) ? ReadWholeFile(log) : "";
    if (said.find("frame", said.find("frame") + 1) != std::string::npos) break;
  }
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << ReadWholeFile(log);
  EXPECT_GT(ReadTum(poses).size(), 20u);
  EXPECT_THAT(ReadWholeFile(log), testing::HasSubstr("tracked"));
}

TEST(TrackCommand, OutputsAreCheckedBeforeTheWork) {
  const auto refused = test::RunUlf("track sim:studio --frames 5 -o /nonexistent/poses.txt");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, testing::HasSubstr("does not exist"));
}

TEST(TrackCommand, RunsAnySourceOfPoses) {
  const auto known =
      test::RunUlf("track 'sim:studio?width=160&height=120' --frames 12 --poses known --deterministic --json");
  ASSERT_EQ(known.exit_code, 0) << known.errors;
  const auto report = nlohmann::json::parse(known.output);
  EXPECT_EQ(report["tracked"], 12);
  EXPECT_LT(report["ate_live_rmse"].get<double>(), 1e-9);
  EXPECT_EQ(report["map_points"], 0);

  const auto unknown = test::RunUlf("track sim:studio --frames 5 --poses rosary");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, testing::HasSubstr("--poses rosary"));
}

}  // namespace
}  // namespace ulf
