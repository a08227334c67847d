#include "tests/docs/examples.h"

#include <algorithm>
#include <regex>
#include <sstream>

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

bool IsACommand(const std::string& line) {
  static const std::regex first_word(R"(^(build/release/\w+|\./run|ulf|for|sudo|mkfifo|echo)(\s.*)?$)");
  return std::regex_match(line, first_word);
}

// "# what it is for" after two blanks, or words after several.
std::string WithoutComment(const std::string& line) {
  static const std::regex comment(R"(\s+#\s.*$|\s{3,}\S.*$)");
  std::string command = std::regex_replace(line, comment, "");
  command.erase(command.find_last_not_of(' ') + 1);
  return command;
}

bool Has(const std::string& text, const char* pattern) {
  return std::regex_search(text, std::regex(pattern));
}

}  // namespace

std::vector<Example> ExamplesOf(const std::string& page, const std::string& text) {
  std::vector<Example> examples;
  std::istringstream lines(text);
  const bool symptoms = page == "docs/troubleshooting.md";
  bool fenced = false, figures = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.starts_with("## ")) figures = line == "## Figures";
    if (line.starts_with("```")) {
      fenced = !fenced;
      continue;
    }
    // Within an item of a list a block is indented by more.
    const bool indented = line.starts_with("    ");
    const std::string code = fenced     ? line
                             : indented ? line.substr(std::min(line.size(), line.find_first_not_of(' ')))
                                        : "";
    if (IsACommand(code)) examples.push_back({page, number, WithoutComment(code)});
    if ((!figures && !symptoms) || !line.starts_with("|")) continue;
    static const std::regex quoted(R"(`(ulf [^`\s]+ [^`]*|\./run [^`]*)`)"),
        cells(R"(^\|[^|]*\|([^|]*)\|.*)");
    // Of symptoms: what tells, not what helps.
    const std::string told = symptoms ? std::regex_replace(line, cells, "$1") : line;
    for (std::sregex_iterator it(told.begin(), told.end(), quoted), end; it != end; ++it)
      if ((*it)[1].str().find("…") == std::string::npos) examples.push_back({page, number, (*it)[1]});
  }
  return examples;
}

Trial TrialOf(const Example& example) {
  Trial trial{.command = example.command, .changes = {}, .data = {}, .why_not = {}};
  std::string& command = trial.command;
  const auto change = [&](const char* pattern, const std::string& by, const std::string& words) {
    const std::string changed = std::regex_replace(command, std::regex(pattern), by);
    if (changed != command) trial.changes.push_back(words);
    command = changed;
  };
  // What stands for something of the reader's own.
  static int folders = 0;
  if (Has(command, R"(^ulf (capture|record|track) URI\b)"))
    change(R"(\bURI\b)", "sim:studio", "URI is the simulated camera");
  if (Has(command, R"(^ulf track sim:studio( --benchmark)?$)"))
    command += " --frames 60", trial.changes.push_back("60 frames");
  change(R"(-o try\b)", "-o try" + std::to_string(++folders), "try is a new folder");
  change(R"(\bSET\b)", "fox", "SET is fox");
  change(R"(--focal-px \.\.\. --width \.\.\. --distance \.\.\. --radius \.\.\.)",
         "--focal-px 1200 --width 1280 --distance 1 --radius 0.15", "... are numbers");
  const struct {
    const char* pattern;
    const char* why_not;
  } kLeftOut[] = {
      {R"(\bsudo\b)", "needs root"},
      {R"((aravis|v4l2|gphoto2):|\b(CAMERA|URI)\b|\bto_ulf\b|>&3)", "needs a camera"},
      {R"(^ulf evaluate vase --proxy points$)", "needs tracked points"},
      {R"(^ulf mask vase$)", "needs the capture of a turntable"},
      {R"(^ulf merge vase$)", "needs exposure brackets"},
      {R"(^\./run\b)", "is a program of its own that builds first: ./run"},
      {R"(_benchmark\b)", "is a benchmark: ./run bench"},
      {R"(^(ulf|\S+/ulf) view (?!.*--screenshot))", "needs a person before a window"},
      {R"(\b(demo)/)", "needs what ./run demo leaves"},
  };
  for (const auto& [pattern, why_not] : kLeftOut)
    if (Has(command, pattern)) {
      trial.why_not = why_not;
      return trial;
    }
  for (const DataName& data : kDataNames)
    if (Has(command, (std::string(R"((^|[ :'/]))") +
                      std::regex_replace(data.name, std::regex(R"(\.)"), "\\.") + R"(($|[ ?'/]))")
                         .c_str()))
      trial.data.push_back(data.name);
  change("build/release/", "", "");
  std::erase(trial.changes, "");
  if (Has(command, R"(-o DIR\b)"))
    change(R"(-o DIR\b)", "-o dir" + std::to_string(++folders), "DIR is a new folder");
  if (Has(command, R"(^ulf simulate\b)")) trial.stop_after_s = 2;
  if (Has(command, R"(^ulf render\b.*--frames \d{3})"))
    change(R"(--frames \d+)", "--frames 6", "6 frames");
  else if (!Has(command, R"(--frames\b)") &&
           (Has(command, R"(^ulf render\b.*--path\b)") || Has(command, R"(^ulf render\b.*-o \S+\.mp4)")))
    command += " --frames 12", trial.changes.push_back("12 frames");
  return trial;
}

void CopyData(const fs::path& data, const fs::path& here) {
  fs::copy(fs::canonical(data), here, fs::copy_options::recursive);
  const auto make_writable = [](const fs::path& path) {
    fs::permissions(path, fs::perms::owner_write, fs::perm_options::add);
  };
  make_writable(here);
  if (!fs::is_directory(here)) return;
  for (const auto& entry : fs::recursive_directory_iterator(here)) make_writable(entry.path());
}

}  // namespace ulf::test
