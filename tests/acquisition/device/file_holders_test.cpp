// Tests: acquisition/device/device_files.
#include "acquisition/device/device_files.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/support/test_paths.h"

namespace ulf::acquisition::file_holders_test {
namespace {

namespace fs = std::filesystem;

void AddProcess(const fs::path& proc, const std::string& id, const std::string& name,
                const std::string& file) {
  fs::create_directories(proc / id / "fd");
  std::ofstream(proc / id / "comm") << name << '\n';
  fs::create_symlink(file, proc / id / "fd" / "5");
}

TEST(FileHolders, AreTheOtherProgramsThatHaveTheFileOpen) {
  const test::ScratchFolder proc;
  AddProcess(proc.path(), "4711", "cheese", "/dev/video0");
  AddProcess(proc.path(), "4712", "editor", "/dev/video1");
  AddProcess(proc.path(), std::to_string(getpid()), "this", "/dev/video0");
  AddProcess(proc.path(), "self", "alias", "/dev/video0");
  EXPECT_THAT(ProgramsHolding("/dev/video0", proc.path().string()),
              ::testing::ElementsAre("cheese (process 4711)"));
  EXPECT_THAT(ProgramsHolding("/dev/video0", (proc / "missing").string()), ::testing::IsEmpty());
}

}  // namespace
}  // namespace ulf::acquisition::file_holders_test
