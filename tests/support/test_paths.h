// Where tests find real pictures and where they may write.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

namespace ulf::test {

// A folder of real captures by others: `name` under ULF_TEST_DATA, else under ../shared/data beside the
// checkout.
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
  int exit_code = -1;
  std::string output;  // standard output
  std::string errors;  // standard error
};

// Runs the ulf binary (ULF_BINARY) with shell-quoted arguments.
CommandResult RunUlf(const std::string& arguments);
// Runs another program with shell-quoted arguments.
CommandResult RunProgram(const std::string& program, const std::string& arguments);

}  // namespace ulf::test

// Each test on real pictures has a sibling on the simulator; this one may be skipped.
#define ULF_NEED_TEST_DATA(variable, name)                      \
  const auto variable##_found = ::ulf::test::TestData(name);    \
  if (!variable##_found) GTEST_SKIP() << "no test data: " name; \
  const std::filesystem::path variable = *variable##_found
