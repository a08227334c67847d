#include "tests/support/test_paths.h"

#include <stdlib.h>
#include <sys/wait.h>

#include <cstdio>
#include <fstream>
#include <iterator>

namespace ulf::test {
namespace fs = std::filesystem;

std::optional<fs::path> TestData(const std::string& name) {
  const char* configured = std::getenv("ULF_TEST_DATA");
  const fs::path checkout = fs::path(__FILE__).parent_path().parent_path().parent_path();
  const fs::path folder = configured ? fs::path(configured) : checkout.parent_path() / "shared" / "data";
  if (!fs::is_directory(folder / name)) return std::nullopt;
  return folder / name;
}

ScratchFolder::ScratchFolder() {
  std::string pattern = (fs::temp_directory_path() / "ulf_test_XXXXXX").string();
  path_ = mkdtemp(pattern.data());
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

CommandResult RunUlf(const std::string& arguments) {
  const char* binary = std::getenv("ULF_BINARY");
  if (!binary)
    ADD_FAILURE() << "ULF_BINARY is not set: run through ctest, or export ULF_BINARY=$PWD/build/release/ulf";
  return RunProgram(binary ? binary : "false", arguments);
}

CommandResult RunProgram(const std::string& program, const std::string& arguments) {
  ScratchFolder scratch;
  const std::string errors_path = (scratch / "stderr").string();
  const std::string command = program + " " + arguments + " 2>" + errors_path;
  CommandResult result;
  FILE* pipe = popen(command.c_str(), "r");
  char buffer[4096];
  while (const std::size_t count = std::fread(buffer, 1, sizeof(buffer), pipe))
    result.output.append(buffer, count);
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  std::ifstream errors(errors_path);
  result.errors.assign(std::istreambuf_iterator<char>(errors), {});
  return result;
}

}  // namespace ulf::test
