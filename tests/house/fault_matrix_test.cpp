// The tables of docs/measured/cameras.md (faults) and docs/measured/tracking.md (where tracking is hard):
// every row has an outcome, and a test that exists.
#include <gmock/gmock.h>

#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"

namespace ulf::test::fault_matrix {
namespace {

namespace fs = std::filesystem;
using ::testing::IsEmpty;

fs::path Checkout() { return CHECKOUT; }

// "Suite.Name" of every TEST, TEST_F and TEST_P under the folder.
std::set<std::string> TestsUnder(const fs::path& folder) {
  static const std::regex macro(R"(\bTEST(?:_F|_P)?\s*\(\s*(\w+)\s*,\s*(\w+)\s*\))");
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = ReadWholeFile(entry.path());
    for (std::sregex_iterator it(text.begin(), text.end(), macro), end; it != end; ++it)
      names.insert((*it)[1].str() + "." + (*it)[2].str());
  }
  return names;
}

struct Row {
  std::string line;
  std::vector<std::string> cells;
};

// A table, by the heading it stands under.
struct Matrix {
  std::string heading;
  std::size_t cells;  // a row; the last one names the test
};
const Matrix kFaults{"\n## Faults of cameras", 4}, kCounted{"\n## Faults of captures", 5},
    kSituations{"\n## Where tracking is hard", 3};

// Its rows, without the head.
std::vector<Row> RowsOf(const std::string& page, const Matrix& matrix) {
  std::vector<Row> rows;
  const std::size_t begin = page.find(matrix.heading);
  if (begin == std::string::npos) return rows;
  const std::size_t end = page.find("\n## ", begin + 1);
  std::istringstream section(page.substr(begin, end == std::string::npos ? end : end - begin));
  int of_the_head = 2;
  for (std::string line; std::getline(section, line);) {
    if (line.empty() || line[0] != '|' || of_the_head-- > 0) continue;
    Row row{line, {}};
    std::istringstream cells(line.substr(1));
    for (std::string cell; std::getline(cells, cell, '|');) row.cells.push_back(cell);
    rows.push_back(row);
  }
  return rows;
}

// What is wrong with the table, a line each.
std::vector<std::string> Faults(const std::string& page, const Matrix& matrix,
                                const std::set<std::string>& tests) {
  static const std::regex quoted("`([^`]+)`");
  std::vector<std::string> faults;
  for (const Row& row : RowsOf(page, matrix)) {
    if (row.cells.size() != matrix.cells) {
      faults.push_back("not " + std::to_string(matrix.cells) + " cells: " + row.line);
      continue;
    }
    for (const std::string& cell : row.cells)
      if (cell.find_first_not_of(' ') == std::string::npos) faults.push_back("an empty cell: " + row.line);
    const std::string& cell = row.cells.back();
    // What cannot be tested without a thing that nobody had says so.
    bool named = cell.starts_with(" none: ") && cell.size() > 9;
    for (std::sregex_iterator it(cell.begin(), cell.end(), quoted), end; it != end; ++it) {
      named = true;
      if (!tests.count((*it)[1])) faults.push_back("no such test: " + (*it)[1].str());
    }
    if (!named) faults.push_back("no test named: " + row.line);
  }
  return faults;
}

TEST(FaultMatrix, EveryRowNamesATestThatExists) {
  const std::set<std::string> tests = TestsUnder(Checkout() / "tests");
  const std::string cameras = ReadWholeFile(Checkout() / "docs" / "measured" / "cameras.md");
  ASSERT_GT(RowsOf(cameras, kFaults).size(), 10u) << "the table was not found";
  EXPECT_THAT(Faults(cameras, kFaults, tests), IsEmpty());
  ASSERT_GT(RowsOf(cameras, kCounted).size(), 10u) << "the table was not found";
  EXPECT_THAT(Faults(cameras, kCounted, tests), IsEmpty());
  const std::string tracking = ReadWholeFile(Checkout() / "docs" / "measured" / "tracking.md");
  ASSERT_GT(RowsOf(tracking, kSituations).size(), 10u) << "the table was not found";
  EXPECT_THAT(Faults(tracking, kSituations, tests), IsEmpty());
}

TEST(FaultMatrix, FindsWhatIsWrong) {
  const std::set<std::string> tests{"A.B"};
  const std::string head = "# Page\n\n## Faults of cameras\n\n| d | f | o | t |\n| --- | --- | --- | --- |\n";
  EXPECT_THAT(Faults(head + "| any | x | y | `A.B` |\n", kFaults, tests), IsEmpty());
  EXPECT_THAT(Faults(head + "| any | x | y | none: needs a USB camera |\n", kFaults, tests), IsEmpty());
  for (const char* row : {"| any | x | y | `A.C` |\n", "| any | x | y | none |\n", "| any | x |  | `A.B` |\n",
                          "| any | x | `A.B` |\n"})
    EXPECT_EQ(Faults(head + row, kFaults, tests).size(), 1u) << row;
  EXPECT_TRUE(TestsUnder(Checkout() / "tests").count("FaultMatrix.FindsWhatIsWrong"));
}

}  // namespace
}  // namespace ulf::test::fault_matrix
