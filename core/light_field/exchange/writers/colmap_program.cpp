#include "core/light_field/exchange/writers/colmap_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "core/base/other_program.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Returns what the program prints; empty if it does not end.
std::string PrintedBy(const fs::path& program, const std::vector<std::string>& arguments) {
  constexpr auto kLongest = std::chrono::seconds(20);
  const auto end = std::chrono::steady_clock::now() + kLongest;
  std::string text;
  const ProgramEnd ended = RunOtherProgram(
      program, arguments, [&](const std::string& line) { text += line + "\n"; },
      [end] { return std::chrono::steady_clock::now() > end; });
  return ended.stopped ? "" : text;
}

std::set<std::string> OptionsIn(const std::string& help) {
  std::set<std::string> names;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);)
    if (const auto name = OptionInHelp(line)) names.insert(*name);
  return names;
}

// Returns "3.8" of "COLMAP 3.8 -- Structure-from-Motion and Multi-View Stereo".
std::string NumberIn(const std::string& help) {
  std::istringstream words(help);
  for (std::string word; words >> word;)
    if (word == "COLMAP" && words >> word) return word;
  return {};
}

bool IsSet(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

// COLMAP uses a GPU by CUDA if it was built with it, and else by OpenGL in a window of Qt.
bool HasGpu(const std::string& help) {
  if (help.find("with CUDA") == std::string::npos) return IsSet("DISPLAY") || IsSet("WAYLAND_DISPLAY");
  std::error_code unknown;
  return fs::exists("/dev/nvidiactl", unknown) || fs::exists("/dev/dxg", unknown);  // the latter of Windows
}

std::string Words(const std::vector<ColmapOption>& options, const std::set<std::string>& known) {
  std::string words;
  for (const std::string& argument : ColmapArguments(options, known)) words += " " + argument;
  return words;
}

}  // namespace

ColmapOption ExtractorGpu(const std::string& value) {
  return {{"SiftExtraction.use_gpu", "FeatureExtraction.use_gpu"}, value};
}

ColmapOption ExtractorThreads(const std::string& value) {
  return {{"SiftExtraction.num_threads", "FeatureExtraction.num_threads"}, value};
}

ColmapOption MatcherGpu(const std::string& value) {
  return {{"SiftMatching.use_gpu", "FeatureMatching.use_gpu"}, value};
}

std::optional<std::string> OptionInHelp(const std::string& line) {
  const std::size_t begin = line.find("--");
  if (begin == std::string::npos || line.find_first_not_of(' ') != begin) return std::nullopt;
  const std::string name = line.substr(begin + 2);
  return name.substr(0, name.find_first_of(" ="));
}

std::vector<std::string> ColmapArguments(const std::vector<ColmapOption>& options,
                                         const std::set<std::string>& known) {
  std::vector<std::string> arguments;
  for (const ColmapOption& option : options) {
    const auto name =
        std::ranges::find_if(option.names, [&](const std::string& each) { return known.contains(each); });
    if (name == option.names.end()) continue;
    arguments.push_back("--" + *name);
    arguments.push_back(option.value);
  }
  return arguments;
}

ColmapVersion InstalledColmap() {
  const fs::path program = ProgramInPath("colmap");
  if (program.empty()) return {};
  const auto options_of = [&](const std::string& command) {
    return OptionsIn(PrintedBy(program, {command, "--" + std::string("help")}));
  };
  const std::string help = PrintedBy(program, {"help"}), number = NumberIn(help);
  const auto extractor = options_of("feature_extractor"), matcher = options_of("exhaustive_matcher");
  if (number.empty() || extractor.empty() || matcher.empty()) return {};
  std::vector<ColmapOption> of_extractor, of_matcher;
  if (help.find("rig_configurator") != std::string::npos) of_extractor.push_back(ExtractorThreads("1"));
  if (!HasGpu(help)) {
    of_extractor.push_back(ExtractorGpu("0"));
    of_matcher.push_back(MatcherGpu("0"));
  }
  return {number, Words(of_extractor, extractor), Words(of_matcher, matcher)};
}

}  // namespace ulf
