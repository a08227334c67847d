// COLMAP as it is installed. Its options changed their names from version to version, and its own help tells
// them.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace ulf {

// An option under the names that it has had; the one that the installed version knows is given.
struct ColmapOption {
  std::vector<std::string> names;
  std::string value;
};

ColmapOption ExtractorGpu(const std::string& value);
ColmapOption ExtractorThreads(const std::string& value);
ColmapOption MatcherGpu(const std::string& value);

// Returns the name of the option that this line of a command's help describes; none: it describes none.
std::optional<std::string> OptionInHelp(const std::string& line);

// Returns names and values in turn, without the options that are not known.
std::vector<std::string> ColmapArguments(const std::vector<ColmapOption>& options,
                                         const std::set<std::string>& known);

// What the commands beside an export for COLMAP say to one version: texts that begin with a space. The
// default is for 3.13 and later, on a GPU.
struct ColmapVersion {
  std::string number;  // "3.8"; empty: COLMAP is not installed, or does not tell its options
  std::string extractor = " --FeatureExtraction.num_threads 1";
  std::string matcher;
};

// Asks the program colmap in PATH. Versions that have rigs (3.12 and later) extract in one thread
// (set_writers.h). Where neither a display nor a GPU serves the program, it is told to use none.
ColmapVersion InstalledColmap();

}  // namespace ulf
