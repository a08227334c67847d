// A name stands for one type in the whole program. Two types of one name link without a word, and then share
// whatever the compiler made for either of them: the program crashes far from both.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::one_definition {
namespace {
namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Key;

using FilesOfType = std::map<std::string, std::vector<std::string>>;

// Types at the left margin, where those of `namespace ulf` stand; not the private ones of a source file.
FilesOfType Definitions(const fs::path& root) {
  static const std::regex definition(
      R"(^(?:struct|class|enum|enum class) ([A-Z]\w*)(?: final)?\s*(?::[^:][^;]*)?\{)");
  FilesOfType found;
  for (const char* folder : {"core", "acquisition", "tracking", "render", "coverage", "commands", "python"}) {
    if (!fs::is_directory(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream file(entry.path());
      std::smatch match;
      bool is_private = false;
      for (std::string line; std::getline(file, line);) {
        if (line == "namespace {") is_private = true;
        if (line == "}  // namespace") is_private = false;
        if (!is_private && std::regex_search(line, match, definition))
          found[match[1]].push_back(fs::relative(entry.path(), root).generic_string());
      }
    }
  }
  return found;
}

std::vector<std::string> DefinedTwice(const fs::path& root) {
  std::vector<std::string> twice;
  for (const auto& [type, files] : Definitions(root))
    if (files.size() > 1) twice.push_back(type + " in " + files.front() + " and " + files.back());
  return twice;
}

void Plant(const fs::path& root, const std::string& path, const std::string& text) {
  fs::create_directories((root / path).parent_path());
  std::ofstream(root / path) << text;
}

TEST(OneDefinition, HoldsForEveryType) { EXPECT_THAT(DefinedTwice(CHECKOUT), IsEmpty()); }

TEST(OneDefinition, LooksAtTheSources) {
  const FilesOfType found = Definitions(CHECKOUT);
  EXPECT_THAT(found, Contains(Key("CameraModel")));
  EXPECT_THAT(found, Contains(Key("CoverageMap")));
  EXPECT_THAT(found, Contains(Key("Renderer")));
}

TEST(OneDefinition, PrivateTypesAndDeclarationsAreFree) {
  const ScratchFolder scratch;
  Plant(scratch.path(), "tracking/a.h", "class Twin;\nstruct Once : Base {\n");
  Plant(scratch.path(), "render/b.cpp", "namespace {\nstruct Once {\n};\n}  // namespace\nclass Twin {\n");
  EXPECT_THAT(DefinedTwice(scratch.path()), IsEmpty());
  Plant(scratch.path(), "render/stereo/c.h", "class Once final {\n");
  EXPECT_THAT(DefinedTwice(scratch.path()), ElementsAre(testing::StartsWith("Once in ")));
}

}  // namespace
}  // namespace ulf::test::one_definition
