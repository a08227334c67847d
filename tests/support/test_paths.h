// Tells tests where real pictures are and where they may write, and runs programs for them.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

namespace ulf::test {

// Returns the folder `name` of real captures by others, in ULF_TEST_DATA or else in shared/data beside the
// checkout; none: it is not there.
std::optional<std::filesystem::path> TestData(const std::string& name);

// An empty folder of this test's own, removed again at the end.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

struct CommandResult {
  int exit_code = -1;  // or 128 + the signal that ended it
  std::string output;  // standard output
  std::string errors;  // standard error
};

// Runs the ulf binary (environment variable ULF_BINARY) with arguments as a shell reads them.
CommandResult RunUlf(const std::string& arguments);
// Runs another program in the same way.
CommandResult RunProgram(const std::string& program, const std::string& arguments);

}  // namespace ulf::test

// Skips the test where the data are not there; each test on real pictures has a sibling on the simulator.
#define ULF_NEED_TEST_DATA(variable, name)                      \
  const auto variable##_found = ::ulf::test::TestData(name);    \
  if (!variable##_found) GTEST_SKIP() << "no test data: " name; \
  const std::filesystem::path variable = *variable##_found
