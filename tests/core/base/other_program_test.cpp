// Tests: core/base/other_program.
//
// Programs that end, fail, hang and print, and what is left of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "core/base/error.h"
#include "core/base/other_program.h"
#include "tests/support/test_paths.h"

namespace ulf::other_program_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::UnorderedElementsAre;

struct Heard {
  ProgramEnd end;
  std::vector<std::string> lines;
};

Heard Shell(
    const std::string& script, const std::function<bool()>& stop = [] { return false; }) {
  Heard heard;
  heard.end = RunOtherProgram(
      "/bin/sh", {"-c", script, "name", "a b", "$HOME;"},
      [&](const std::string& line) { heard.lines.push_back(line); }, stop);
  return heard;
}

bool Runs(const std::string& process) { return kill(std::stoi(process), 0) == 0; }

TEST(OtherProgram, GivesItsLinesAndItsEnd) {
  const Heard heard = Shell("echo one; echo two >&2; printf 'three\\rfour'; exit 3");
  EXPECT_THAT(heard.lines, UnorderedElementsAre("one", "two", "three", "four"));
  EXPECT_EQ(heard.end.status, 3);
  EXPECT_FALSE(heard.end.stopped);
  EXPECT_EQ(Shell("kill -9 $$").end.status, 128 + SIGKILL);
}

TEST(OtherProgram, TakesWordsAsTheyAreAndReadsNothing) {
  EXPECT_THAT(Shell(R"(echo "$1"; echo "$2"; cat)").lines, ElementsAre("a b", "$HOME;"));
}

TEST(OtherProgram, EndsWhenAsked) {
  bool ended = false;
  std::vector<std::string> lines;
  const auto started = std::chrono::steady_clock::now();
  const ProgramEnd end = RunOtherProgram(
      "/bin/sh", {"-c", "echo $$; exec sleep 60"},
      [&](const std::string& line) {
        lines.push_back(line);
        ended = true;
      },
      [&] { return ended; });
  EXPECT_TRUE(end.stopped);
  EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::seconds(20));
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_FALSE(Runs(lines[0]));
}

TEST(OtherProgram, EndsWithWhoReadsIt) {
  std::string process;
  EXPECT_THROW(RunOtherProgram(
                   "/bin/sh", {"-c", "echo $$; exec sleep 60"},
                   [&](const std::string& line) {
                     process = line;
                     throw Error("enough");
                   },
                   [] { return false; }),
               Error);
  EXPECT_FALSE(Runs(process));
}

TEST(OtherProgram, IsFoundInThePath) {
  const test::ScratchFolder scratch;
  fs::create_directories(scratch / "first/tool");  // a folder of that name
  fs::create_directories(scratch / "second");
  fs::create_directories(scratch / "third");
  for (const char* folder : {"second", "third"}) std::ofstream(scratch / folder / "tool") << "#!/bin/sh\n";
  fs::permissions(scratch / "third/tool", fs::perms::owner_all);
  const std::string before = std::getenv("PATH");
  setenv("PATH", fmt::format("{0}/first:{0}/none:{0}/second:{0}/third", scratch.path().string()).c_str(), 1);
  EXPECT_EQ(ProgramInPath("tool"), scratch / "third/tool");
  EXPECT_EQ(ProgramInPath("nothing"), "");
  setenv("PATH", before.c_str(), 1);
}

}  // namespace
}  // namespace ulf::other_program_test
