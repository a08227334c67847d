// The test of a file is found by its name: a test file begins with the units that it tests,
//     // Tests: core/base/error, core/base/counted,
//     // core/base/lowercase.
// and stands in tests/ under the folder of one of them. A unit is a header, its source or both, named by its
// path without ending. Every unit of the program is named by a test.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {
namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::vector<std::string> kFloors{"core", "acquisition", "tracking", "render", "coverage", "commands"};

std::vector<fs::path> SourcesUnder(const fs::path& folder) {
  std::vector<fs::path> found;
  if (!fs::exists(folder)) return found;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp") found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

std::string WithoutEnding(const fs::path& path) {
  return (path.parent_path() / path.stem()).generic_string();
}

std::set<std::string> UnitsOf(const fs::path& root) {
  std::set<std::string> units;
  for (const std::string& floor : kFloors)
    for (const fs::path& source : SourcesUnder(root / floor))
      units.insert(WithoutEnding(source.lexically_relative(root)));
  if (fs::exists(root / "main.cpp")) units.insert("main");
  return units;
}

// Empty: the file does not begin with such a line.
std::vector<std::string> NamedBy(const fs::path& test) {
  std::ifstream stream(test);
  std::string line, names;
  if (!std::getline(stream, line) || !line.starts_with("// Tests: ")) return {};
  names = line.substr(10);
  while (!names.ends_with('.') && std::getline(stream, line) && line.starts_with("// "))
    names += ' ' + line.substr(3);
  if (names.ends_with('.')) names.pop_back();
  std::vector<std::string> named(1);
  for (const char letter : names) {
    if (letter == ',') named.emplace_back();
    if (letter != ',' && letter != ' ') named.back() += letter;
  }
  return named;
}

std::vector<std::string> Faults(const fs::path& root) {
  std::vector<std::string> faults;
  const std::set<std::string> units = UnitsOf(root);
  std::set<std::string> tested;
  for (const fs::path& path : SourcesUnder(root / "tests")) {
    const std::string test = path.lexically_relative(root).generic_string();
    const std::vector<std::string> named = NamedBy(path);
    for (const std::string& unit : named) {
      if (!units.contains(unit)) faults.push_back(test + " tests '" + unit + "', which is not there");
      tested.insert(unit);
    }
    if (!test.ends_with("_test.cpp")) continue;
    const bool of_a_floor = std::any_of(kFloors.begin(), kFloors.end(), [&](const std::string& floor) {
      return test.starts_with("tests/" + floor + "/");
    });
    if (!of_a_floor) continue;
    if (named.empty()) {
      faults.push_back(test + " does not begin with the units that it tests (// Tests: core/base/error.)");
    } else if (std::none_of(named.begin(), named.end(), [&](const std::string& unit) {
                 return "tests" / fs::path(unit).parent_path() == fs::path(test).parent_path();
               })) {
      faults.push_back(test + " tests nothing of its own folder: it should stand in tests/" +
                       fs::path(named[0]).parent_path().generic_string() + "/");
    }
  }
  for (const std::string& unit : units)
    if (!tested.contains(unit)) faults.push_back("no test names " + unit);
  return faults;
}

void Write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

TEST(TestsByName, EveryUnitIsNamedByATestThatStandsWhereItBelongs) {
  const std::vector<std::string> faults = Faults(CHECKOUT);
  EXPECT_THAT(faults, IsEmpty());
}

TEST(TestsByName, WhatIsMissingOrNamedWronglyIsFound) {
  const ScratchFolder folder;
  Write(folder / "core/base/error.h", "");
  Write(folder / "core/base/counted.h", "");
  Write(folder / "core/base/counted.cpp", "");
  Write(folder / "tests/core/base/words_test.cpp",
        "// Tests: core/base/error,\n// core/base/counted.\nint x;\n");
  EXPECT_THAT(Faults(folder.path()), IsEmpty());

  Write(folder / "core/frames/frame.h", "");
  EXPECT_THAT(Faults(folder.path()), ElementsAre("no test names core/frames/frame"));
  Write(folder / "tests/core/base/frame_test.cpp", "// Tests: core/frames/frame.\n");
  EXPECT_THAT(Faults(folder.path()), ElementsAre(HasSubstr("it should stand in tests/core/frames/")));
  Write(folder / "tests/core/base/frame_test.cpp", "// A frame.\n");
  EXPECT_THAT(Faults(folder.path()), ElementsAre(HasSubstr("frame_test.cpp does not begin with"),
                                                 "no test names core/frames/frame"));
  Write(folder / "tests/core/base/frame_test.cpp", "// Tests: core/base/error, core/image/fame.\n");
  EXPECT_THAT(Faults(folder.path()), ElementsAre(HasSubstr("tests 'core/image/fame', which is not there"),
                                                 "no test names core/frames/frame"));
}

}  // namespace
}  // namespace ulf::test
