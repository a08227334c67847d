// What no source may call. Nobody writes past the guard of the standard streams
// (commands/standard_streams): it stands behind `stdout`, `stderr` and the streams of the standard library,
// not behind the descriptors. Clang 14, which reads the sources for ./run tidy and ./run fuzz, does not
// compile the views of GCC 12's library, nor its algorithms that return a subrange.
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

std::vector<std::string> ViewsIn(const std::string& text) {
  static const std::regex forbidden(
      R"(std::views|ranges::views|ranges::(unique|remove|remove_if|partition|stable_partition|rotate|search|)"
      R"(search_n|equal_range|find_end|subrange)\b)");
  std::smatch found;
  if (!std::regex_search(text, found, forbidden)) return {};
  return {found.str()};
}

// What `find` finds in the sources under `places`, with the file's name.
std::vector<std::string> InSources(const std::vector<const char*>& places,
                                   std::vector<std::string> (*find)(const std::string&)) {
  std::vector<std::string> found;
  for (const char* place : places)
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(CHECKOUT) / place)) {
      const fs::path& source = entry.path();
      if (source.extension() != ".cpp" && source.extension() != ".h") continue;
      if (source.stem() == "standard_streams" || source.stem() == "forbidden_calls_test") continue;
      std::ifstream stream(source);
      for (const std::string& what : find({std::istreambuf_iterator<char>(stream), {}}))
        found.push_back(source.filename().string() + ": " + what);
    }
  return found;
}

TEST(ForbiddenCalls, NobodyBypassesTheGuardOfStreams) {
  EXPECT_THAT(InSources({"core", "acquisition", "tracking", "render", "coverage", "commands", "python"},
                        WritesPastTheGuard),
              IsEmpty());
  std::ifstream main(fs::path(CHECKOUT) / "main.cpp");
  EXPECT_THAT(WritesPastTheGuard({std::istreambuf_iterator<char>(main), {}}), IsEmpty());
}

TEST(ForbiddenCalls, NobodyUsesViewsOfTheLibrary) {
  EXPECT_THAT(InSources({"core", "acquisition", "tracking", "render", "coverage", "commands", "python",
                         "tests", "examples"},
                        ViewsIn),
              IsEmpty());
}

TEST(ForbiddenCalls, AreFound) {
  EXPECT_THAT(WritesPastTheGuard("write(2, text, 3); write(STDERR_FILENO, text, 3); dprintf(1, \"x\");"),
              SizeIs(3));
  EXPECT_THAT(WritesPastTheGuard("isatty(fileno(stderr)); fopen(\"/dev/stderr\", \"w\");"), SizeIs(2));
  EXPECT_THAT(WritesPastTheGuard("fmt::print(stderr, \"x\"); write(descriptor, text, 3); std::cout << 1;"),
              IsEmpty());
  EXPECT_THAT(ViewsIn("ids | std::views::keys; light_field.views"), SizeIs(1));
  EXPECT_THAT(ViewsIn("std::ranges::remove_if(ids, is_odd); std::ranges::remove_copy(ids, to, 3);"),
              SizeIs(1));
}

}  // namespace
}  // namespace ulf::test
