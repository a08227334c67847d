// Nobody writes past the guard of the standard streams (commands/standard_streams): it stands behind
// `stdout`, `stderr` and the streams of the standard library, not behind the descriptors.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

namespace ulf::test {
namespace {
namespace fs = std::filesystem;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::vector<std::string> WritesPastTheGuard(const std::string& text) {
  static const std::regex past(
      R"(\b(write|dprintf|send|fdopen|dup2)\((STD(OUT|ERR)_FILENO|[12]),|\bfreopen\(|\bfclose\(std(out|err)\))"
      R"(|\bfileno\(std(out|err)\)|/dev/(stdout|stderr|tty)\b|/dev/fd/)");
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), past), end; it != end; ++it)
    found.push_back(it->str());
  return found;
}

TEST(StandardStreamsInTheSources, NobodyBypassesTheGuard) {
  std::vector<std::string> found;
  std::vector<fs::path> sources{fs::path(CHECKOUT) / "main.cpp"};
  for (const char* folder : {"core", "acquisition", "tracking", "render", "coverage", "commands"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(CHECKOUT) / folder))
      if (entry.path().extension() == ".cpp" || entry.path().extension() == ".h")
        sources.push_back(entry.path());
  for (const fs::path& source : sources) {
    if (source.stem() == "standard_streams") continue;
    std::ifstream stream(source);
    for (const std::string& what : WritesPastTheGuard({std::istreambuf_iterator<char>(stream), {}}))
      found.push_back(source.filename().string() + ": " + what);
  }
  EXPECT_THAT(found, IsEmpty());
}

TEST(StandardStreamsInTheSources, FindsABypassOfTheGuard) {
  EXPECT_THAT(WritesPastTheGuard("write(2, text, 3); write(STDERR_FILENO, text, 3); dprintf(1, \"x\");"),
              SizeIs(3));
  EXPECT_THAT(WritesPastTheGuard("isatty(fileno(stderr)); fopen(\"/dev/stderr\", \"w\");"), SizeIs(2));
  EXPECT_THAT(WritesPastTheGuard("fmt::print(stderr, \"x\"); write(descriptor, text, 3); std::cout << 1;"),
              IsEmpty());
}

}  // namespace
}  // namespace ulf::test
