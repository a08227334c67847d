// What people read says "1 round", not "1 rounds": a message that puts a number before a noun asks
// core/base/counted.h for both.
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

// Lines with "{} rounds" and the like. After "of", "all", "the" and so on there are several.
std::vector<std::string> BareCounts(const std::string& text) {
  static const std::regex several(
      R"(\b(of|all|the|its|x|needs|holds|into|for) \{(?::\.0f)?\} \w+|\{\}x\{\} \w+)");
  static const std::regex counted(
      R"(\{(?::\.0f)?\} (rounds|features|points|frames|views|photographs|packets|requests|markers|images|keyframes)(?![\w/]))");
  std::vector<std::string> found;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = std::regex_replace(text.substr(begin, end - begin), several, "");
    if (std::regex_search(line, counted)) found.push_back(line);
    begin = end + 1;
  }
  return found;
}

TEST(Words, ANumberBeforeANounIsCounted) {
  std::vector<std::string> found;
  for (const char* folder : {"core", "acquisition", "tracking", "render", "coverage", "commands"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(CHECKOUT) / folder)) {
      if (entry.path().extension() != ".cpp") continue;
      std::ifstream stream(entry.path());
      std::string text{std::istreambuf_iterator<char>(stream), {}};
      // What developers turn on for themselves may stay short.
      text = std::regex_replace(text, std::regex(R"(spdlog::debug\(\s*"[^"]*")"), "");
      for (const std::string& line : BareCounts(text))
        found.push_back(entry.path().filename().string() + ": " + line);
    }
  EXPECT_THAT(found, IsEmpty());
}

TEST(Words, FindsABareCount) {
  EXPECT_THAT(BareCounts("print(\"{}: {} of them changed, in {} rounds\\n\", a);"), SizeIs(1));
  EXPECT_THAT(BareCounts("text = \"seen in {} views\";\nother"), SizeIs(1));
  EXPECT_THAT(BareCounts("none of the {} files, of {} views, all {} images, {}x{} images"), IsEmpty());
}

}  // namespace
}  // namespace ulf::test
