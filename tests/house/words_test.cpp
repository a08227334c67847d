// What people read says "1 round", not "1 rounds": a message that puts a number before a noun asks
// core/base/counted.h for both. And what developers read has its limits: names of tests, widths of comments.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"

namespace ulf::test {
namespace {
namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::size_t kLongestTestName = 50, kWidestComment = 110;

// Headers and sources under the folders of the checkout.
std::vector<fs::path> SourcesIn(const std::vector<std::string>& folders) {
  std::vector<fs::path> found;
  for (const std::string& folder : folders)
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(CHECKOUT) / folder))
      if (entry.path().extension() == ".cpp" || entry.path().extension() == ".h")
        found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

const std::vector<std::string> kProduct{"core",     "acquisition", "tracking", "render",
                                        "coverage", "commands",    "python"};

std::vector<std::string> LinesOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// Characters of UTF-8.
std::size_t WidthOf(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

// "Suite.Name" of the tests that are too long.
std::vector<std::string> LongTestNames(const std::string& text) {
  static const std::regex macro(R"(\bTEST(?:_F|_P)?\s*\(\s*(\w+)\s*,\s*(\w+)\s*\))");
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), macro), end; it != end; ++it)
    if (const std::string name = (*it)[1].str() + "." + (*it)[2].str(); name.size() > kLongestTestName)
      found.push_back(name);
  return found;
}

// Comment lines that are too wide, but for rows of tables and what has no space to break at (an address).
std::vector<std::string> WideComments(const std::string& text) {
  static const std::regex comment(R"(^\s*//+\s*(\S.*)$)");
  std::vector<std::string> found;
  std::smatch match;
  for (const std::string& line : LinesOf(text))
    if (WidthOf(line) > kWidestComment && std::regex_match(line, match, comment) &&
        match[1].str().find(' ') != std::string::npos && match[1].str().find(" | ") == std::string::npos)
      found.push_back(line);
  return found;
}

// First lines of comments, also behind code, that begin as a piece of a sentence does.
std::vector<std::string> Fragments(const std::string& text) {
  static const std::regex begins(R"(^(.*?)// (Of|Where) .*$)");
  static const std::regex comment(R"(^\s*//.*\S.*$)");
  std::vector<std::string> found;
  std::smatch match;
  bool goes_on = false;
  for (const std::string& line : LinesOf(text)) {
    if (std::regex_match(line, match, begins) &&
        (!goes_on || match[1].str().find_first_not_of(' ') != std::string::npos))
      found.push_back(line);
    goes_on = std::regex_match(line, comment) && !line.ends_with("//");
  }
  return found;
}

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
  for (const fs::path& source : SourcesIn(kProduct)) {
    if (source.extension() != ".cpp") continue;
    // Debug messages may stay short.
    const std::string text =
        std::regex_replace(ReadWholeFile(source), std::regex(R"(spdlog::debug\(\s*"[^"]*")"), "");
    for (const std::string& line : BareCounts(text))
      found.push_back(source.filename().string() + ": " + line);
  }
  EXPECT_THAT(found, IsEmpty());
}

TEST(Words, FindsABareCount) {
  EXPECT_THAT(BareCounts("print(\"{}: {} of them changed, in {} rounds\\n\", a);"), SizeIs(1));
  EXPECT_THAT(BareCounts("text = \"seen in {} views\";\nother"), SizeIs(1));
  EXPECT_THAT(BareCounts("none of the {} files, of {} views, all {} images, {}x{} images"), IsEmpty());
}

TEST(Words, NamesOfTestsAreShort) {
  std::vector<std::string> found;
  for (const fs::path& source : SourcesIn({"tests"}))
    for (const std::string& name : LongTestNames(ReadWholeFile(source)))
      found.push_back(source.filename().string() + ": " + name);
  EXPECT_THAT(found, IsEmpty());
}

TEST(Words, CommentsAreNotWide) {
  std::vector<std::string> found, folders = kProduct;
  folders.push_back("tests");
  for (const fs::path& source : SourcesIn(folders))
    for (const std::string& line : WideComments(ReadWholeFile(source)))
      found.push_back(source.filename().string() + ": " + line);
  EXPECT_THAT(found, IsEmpty());
}

TEST(Words, NoCommentBeginsWithinASentence) {
  std::vector<std::string> found;
  for (const fs::path& source : SourcesIn(kProduct))
    for (const std::string& line : Fragments(ReadWholeFile(source)))
      found.push_back(source.filename().string() + ": " + line);
  EXPECT_THAT(found, IsEmpty());
}

TEST(Words, FindsLongNamesWideCommentsAndFragments) {
  const std::string long_name(kLongestTestName - 1, 'a'), wide(kWidestComment, 'b');
  const std::string macro = "TEST";  // apart from what follows, else this would be a test
  EXPECT_THAT(
      LongTestNames(macro + "_F(S, " + long_name + ") {\n" + macro + "(S, " + long_name.substr(1) + ") {\n"),
      ElementsAre("S." + long_name));
  EXPECT_THAT(WideComments("  // a " + wide + "\n// " + wide + "\n// a | " + wide + "\nint a" + wide + ";\n"),
              SizeIs(1));
  EXPECT_THAT(WideComments("// \u00b0 " + wide.substr(5) + "\n"), IsEmpty()) << "characters, not bytes";
  EXPECT_THAT(Fragments("// Of a ratio.\nint a;  // Where it is.\n// The middle\n// Of all.\n"), SizeIs(2));
}

}  // namespace
}  // namespace ulf::test
