// Captures of simulated scenes with each way to decide what is covered (`ulf capture --cover`), and what
// pictures from their light fields are worth: rendered over their own mesh at places between the views,
// against the simulator's pictures there.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/floors.h"

namespace ulf::test {

struct CoverCase {
  std::string scene = "studio";
  std::uint64_t seed = 1;
  std::string person;              // --operator; empty: the hand that scans by a plan
  std::vector<std::string> cover;  // {"--quality", "fast"}, {"--cover", "measured:33"}
  double most_seconds = 150;       // of the camera's time
};

struct CoverRun {
  int views = 0;
  double covered = 0;                  // as the capture says
  double median_db = 0, worst_db = 0;  // on the subject's disc: the middle and the worst tenth of the places
  double frame_db = 0;                 // of whole pictures, median
};

// `program`: ulf. Throws Error with what it printed when it fails.
CoverRun RunCover(const std::string& program, const CoverCase& which, const std::filesystem::path& folder);

}  // namespace ulf::test
