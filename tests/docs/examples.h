// The examples that README, CONTRIBUTING and docs/ give: read out of the pages themselves, so that what is
// tried is what people read.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ulf::test {

struct Example {
  std::string page;     // "docs/tracking.md"
  int line = 0;         // in it
  std::string command;  // as it stands there, without its comment
};

// Of indented and fenced blocks, and of the table under "## Figures" the commands in backquotes that are
// written out (no "…"): lines that begin with one of our programs, a loop, or what a shell does around them.
std::vector<Example> ExamplesOf(const std::string& page, const std::string& text);

// What becomes of one: run as `command` (with what stands for a reader's own things put in their place, and
// bounded where it would take long: `changes` says what), or left out because `why_not`.
struct Trial {
  std::string command;
  std::vector<std::string> changes;
  std::vector<std::string> data;  // names of data sets that must be there
  std::string why_not;
  int stop_after_s = 0;  // it serves until it is stopped
};
Trial TrialOf(const Example& example);

// Where a data set lies that a page calls by a name of its own: name in the page, and path under the test
// data.
struct DataName {
  const char* name;
  const char* path;
};
inline constexpr DataName kDataNames[] = {{"fox", "fox_half"},
                                          {"fern", "llff_fern"},
                                          {"kitchen", "handheld_kitchen"},
                                          {"handheld_kitchen", "handheld_kitchen"},
                                          {"photographs", "llff_fern/images_4"},
                                          {"walk.mp4", "handheld_kitchen/first300.mp4"},
                                          {"intrinsics.txt", "handheld_kitchen/intrinsics.txt"},
                                          {"reference.txt", "handheld_kitchen/colmap_reference.txt"},
                                          {"colmap_reference.txt", "handheld_kitchen/colmap_reference.txt"},
                                          {"shop_grid_even", "shop_grid_even"},
                                          {"scan_synthetic", "scan_synthetic"},
                                          {"aruco_data", "aruco_board/aruco_data"}};

// A data set, or a file of one, as one of our own at `here`: what a command writes into it stays here. (Links
// would not do: a light field only holds what lies inside it.)
void CopyData(const std::filesystem::path& data, const std::filesystem::path& here);

}  // namespace ulf::test
