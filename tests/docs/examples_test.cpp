// Rules by which examples are found and tried: every day. That they run and come to what the pages promise:
// ULF_RUN_EXAMPLES, in the long tests.
#include "tests/docs/examples.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <utility>

#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {
namespace fs = std::filesystem;

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

fs::path Checkout() { return CHECKOUT; }

std::string TextOf(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<std::string> Pages() {
  std::vector<std::string> pages{"README.md", "CONTRIBUTING.md", "udev/README.md"};
  for (const auto& entry : fs::recursive_directory_iterator(Checkout() / "docs"))
    if (entry.path().extension() == ".md")
      pages.push_back(entry.path().lexically_relative(Checkout()).generic_string());
  std::sort(pages.begin(), pages.end());
  return pages;
}

// Every "ulf COMMAND ... --option" of a page, in code or between backticks: command and option.
std::set<std::pair<std::string, std::string>> OptionsNamedIn(const std::string& text) {
  static const std::regex command(R"(\bulf ([a-z-]+)((?: (?![|#])[^`\n|#;]*)?))"),
      option(R"((?:^| )(--[a-z][a-z0-9-]*))");
  std::set<std::pair<std::string, std::string>> named;
  for (std::sregex_iterator it(text.begin(), text.end(), command), end; it != end; ++it) {
    const std::string arguments = (*it)[2];
    for (std::sregex_iterator at(arguments.begin(), arguments.end(), option), none; at != none; ++at)
      named.emplace((*it)[1], (*at)[1]);
  }
  return named;
}

// What a page promises of an example, and what the example prints. Both by regular expressions whose groups
// are the numbers, in the same order; `within` is the share by which each may be off. A page whose sentence
// is written anew without its figures fails here, too.
struct Promise {
  const char* page;
  const char* promised;
  const char* command;  // part of it
  const char* printed;
  double within;
};
const Promise kPromises[] = {
#include "tests/docs/promises.inc"
};

std::vector<double> Numbers(const std::string& text, const char* pattern) {
  std::smatch match;
  std::vector<double> numbers;
  if (!std::regex_search(text, match, std::regex(pattern))) return numbers;
  for (std::size_t i = 1; i < match.size(); ++i) numbers.push_back(std::stod(match[i]));
  return numbers;
}

TEST(Examples, AreReadOutOfThePages) {
  const std::string page =
      "# Page\n\n    ulf info vase --cap 60x40    # what it came to\n    {\"json\": 1}\n"
      "    ulf simulate studio                    one camera\n\n```\nulf devices\n```\n\n"
      "    ulf capture 'sim:studio?seed=1' -o a --frames 3\n\n"
      "- an item\n\n        ulf repair vase --write\n     \n\n"
      "| x | `ulf evaluate set` |\n\n## Figures\n\n| x | `ulf evaluate shop_grid_even --subject 0,0,-8,1` | "
      "`ulf "
      "track … --truth a` |\n| `ulf refine`: the demo | `./run demo` |\n";
  std::vector<std::string> commands;
  for (const Example& example : ExamplesOf("page.md", page)) commands.push_back(example.command);
  EXPECT_THAT(commands,
              ElementsAre("ulf info vase --cap 60x40", "ulf simulate studio", "ulf devices",
                          "ulf capture 'sim:studio?seed=1' -o a --frames 3", "ulf repair vase --write",
                          "ulf evaluate shop_grid_even --subject 0,0,-8,1", "./run demo"));
}

TEST(Examples, OfSymptomsAreTheTellingCommands) {
  const std::string page =
      "| what you see | what tells | what helps |\n| --- | --- | --- |\n"
      "| lost | `ulf track URI`: said; `ulf info vase` | `ulf refine vase` |\n";
  std::vector<std::string> commands;
  for (const Example& example : ExamplesOf("docs/troubleshooting.md", page))
    commands.push_back(TrialOf(example).command);
  EXPECT_THAT(commands, ElementsAre("ulf track sim:studio --frames 60", "ulf info vase"));
  EXPECT_THAT(ExamplesOf("docs/exchange.md", page), IsEmpty());
}

// A page that names an option the program does not have, or no longer has, sends people into an error.
TEST(Examples, NameOnlyOptionsThatThereAre) {
  std::map<std::string, std::string> help;
  int options = 0;
  for (const std::string& page : Pages())
    for (const auto& [command, option] : OptionsNamedIn(TextOf(Checkout() / page))) {
      if (!help.contains(command)) {
        help[command] = RunUlf(command + " --help-all").output;  // with those of the forms of ulf export
      }
      ++options;
      EXPECT_TRUE(std::regex_search(help[command], std::regex(option + "([^a-z0-9-]|$)")))
          << page << ": ulf " << command << " has no " << option;
    }
  EXPECT_GT(options, 100);
}

// Programs that are started, and others or tests of ctest's that are named.
TEST(Examples, TestsNamedOnPagesExist) {
  const fs::path programs = fs::path(std::getenv("ULF_BINARY")).parent_path();
  std::set<std::string> started, named;
  std::ifstream list(programs / "test_sources.txt");
  for (std::string source, program, entry, line; std::getline(list, line);) {
    std::istringstream(line) >> source >> program >> entry;
    started.insert(program);
    named.insert({program, entry});
  }
  static const std::regex start(
      R"((?:ninja -C \S+ |build/\w+/)(\w+_tests?)\b|\b(\w+_tests?) --gtest_filter)");
  static const std::regex name(R"((?:`|-R )([a-z0-9_]+_tests?)[` ])");
  for (const std::string& page : Pages()) {
    const std::string text = TextOf(Checkout() / page);
    for (std::sregex_iterator at(text.begin(), text.end(), start), end; at != end; ++at)
      EXPECT_TRUE(started.contains((*at)[1].str() + (*at)[2].str())) << page << ": " << at->str();
    for (std::sregex_iterator at(text.begin(), text.end(), name), end; at != end; ++at)
      EXPECT_TRUE(named.contains((*at)[1])) << page << ": " << at->str();
  }
  EXPECT_GT(started.size(), 10u);
}

TEST(Examples, AreTriedOrLeftOutByRules) {
  const auto trial = [](const char* command) { return TrialOf({"page.md", 1, command}); };
  EXPECT_EQ(trial("sudo ls").why_not, "needs root");
  EXPECT_EQ(trial("ulf capture aravis: -o vase").why_not, "needs a camera");
  EXPECT_THAT(trial("./run demo").why_not, HasSubstr("./run"));
  EXPECT_THAT(trial("ulf view vase").why_not, HasSubstr("window"));
  EXPECT_EQ(trial("ulf view vase --screenshot a.jpg").why_not, "");
  EXPECT_THAT(trial("ulf import fox -o fox_light_field").data, ElementsAre("fox"));
  EXPECT_THAT(trial("ulf render fox_light_field -o a.png").data, IsEmpty()) << "is made by the one before";
  EXPECT_THAT(trial("ulf track 'replay:kitchen?glob=*.jpg' --calibration intrinsics.txt").data,
              ElementsAre("kitchen", "intrinsics.txt"));
  EXPECT_EQ(trial("ulf render vase --path vertigo --frames 240 -o v").command,
            "ulf render vase --path vertigo --frames 6 -o v");
  EXPECT_EQ(trial("build/release/ulf info a").command, "ulf info a");
  EXPECT_EQ(trial("ulf features URI NAME").why_not, "needs a camera");
  EXPECT_THAT(trial("ulf import SET -o out").data, ElementsAre("fox"));
}

TEST(Examples, CommandsDoNotChangeTheirData) {
  const ScratchFolder data, scratch;
  fs::create_directories(data / "set/images");
  std::ofstream(data / "set/images/1.png") << "one";
  std::ofstream(data / "set/journal.jsonl") << "{}\n";
  CopyData(data / "set", scratch / "here");
  EXPECT_EQ(TextOf(scratch / "here/images/1.png"), "one");
  fs::create_directories(scratch / "here/cache");
  std::ofstream(scratch / "here/images/2.png") << "two";
  std::ofstream(scratch / "here/journal.jsonl", std::ios::app) << "{}\n";
  EXPECT_FALSE(fs::exists(data / "set/cache"));
  EXPECT_FALSE(fs::exists(data / "set/images/2.png"));
  EXPECT_EQ(TextOf(data / "set/journal.jsonl"), "{}\n");
  CopyData(data / "set/images/1.png", scratch / "one.png");
  EXPECT_EQ(TextOf(scratch / "one.png"), "one");
}

TEST(Examples, AreFoundWithTheirPromises) {
  std::size_t found = 0, tried = 0;
  for (const std::string& page : Pages())
    for (const Example& example : ExamplesOf(page, TextOf(Checkout() / page))) {
      ++found;
      tried += TrialOf(example).why_not.empty();
    }
  EXPECT_GT(found, 50u);
  EXPECT_GT(tried, 25u);
  for (const Promise& promise : kPromises) {
    const std::string text = TextOf(Checkout() / promise.page);
    EXPECT_THAT(Numbers(text, promise.promised), ::testing::Not(IsEmpty()))
        << promise.page << " no longer says: " << promise.promised;
    bool there = false;
    for (const Example& example : ExamplesOf(promise.page, text))
      there |= example.command.find(promise.command) != std::string::npos;
    EXPECT_TRUE(there) << promise.page << " no longer has: " << promise.command;
  }
}

#ifdef ULF_RUN_EXAMPLES

class ExampleRuns {
 public:
  // In a folder of the page's own, with what its examples take for granted.
  explicit ExampleRuns(const std::string& page) {
    for (const DataName& data : kDataNames) {
      const std::string path = data.path;
      const auto set = TestData(path.substr(0, path.find('/')));
      if (!set) continue;
      const fs::path target = set->parent_path() / path;
      if (fs::exists(target)) CopyData(target, scratch_ / data.name);
      there_[data.name] = fs::exists(target);
    }
    needs_vase_ = TextOf(Checkout() / page).find(" vase") != std::string::npos;
  }

  // Output and errors together; none where it was left out.
  std::optional<std::string> Run(const Example& example) {
    const std::string where = fmt::format("{}:{}: {}", example.page, example.line, example.command);
    const Trial trial = TrialOf(example);
    if (!trial.why_not.empty()) return LeaveOut(where, trial.why_not);
    for (const std::string& data : trial.data)
      if (!there_[data]) {
        without_data_[example.command] = data;
        return LeaveOut(where, "needs the data set " + data);
      }
    if (needs_vase_ && example.command.find(" vase") != std::string::npos) MakeVase();
    for (const std::string& change : trial.changes) fmt::print("  here: {}\n", change);
    std::string command = trial.command;
    if (trial.stop_after_s > 0) command = fmt::format("timeout -s INT {} {}", trial.stop_after_s, command);
    const auto start = std::chrono::steady_clock::now();
    const auto [status, output] = Shell(command);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    fmt::print("ran {:6.1f} s  {}\n", seconds, where);
    std::fflush(stdout);
    const bool stopped = trial.stop_after_s > 0 && status == 124;
    EXPECT_TRUE(status == 0 || stopped) << where << " ended with " << status << ":\n" << output;
    return output;
  }

  // The data set for want of which an example with this in it was left out; empty: there is none.
  std::string DataMissingFor(const std::string& part_of_command) const {
    for (const auto& [command, data] : without_data_)
      if (command.find(part_of_command) != std::string::npos) return data;
    return {};
  }

 private:
  static std::optional<std::string> LeaveOut(const std::string& where, const std::string& why) {
    fmt::print("left out      {}: {}\n", where, why);
    return std::nullopt;
  }

  // A light field of the reader's own: of the simulated studio.
  void MakeVase() {
    if (fs::exists(scratch_ / "vase")) return;
    const auto [status, output] = Shell(
        "ulf capture 'sim:studio?look_away=0&row_deg=4' -o vase --headless --poses known --subject "
        "0,0,0.07,0.17 --quality fast --until-covered 30x20");
    ASSERT_EQ(status, 0) << output;
  }

  std::pair<int, std::string> Shell(const std::string& command) const {
    const fs::path output = scratch_ / "output.txt";
    const fs::path programs = fs::path(std::getenv("ULF_BINARY")).parent_path();
    const std::string script =
        fmt::format("cd '{}' && unset OMP_NUM_THREADS && export PATH='{}':$PATH && ( {} ) >'{}' 2>&1",
                    scratch_.path().string(), programs.string(), command, output.string());
    const int status = std::system(script.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), TextOf(output)};
  }

  ScratchFolder scratch_;
  std::map<std::string, bool> there_;
  std::map<std::string, std::string> without_data_;
  bool needs_vase_ = false;
};

class EveryPage : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryPage, ItsExamplesRunAndComeToWhatItSays) {
  ASSERT_NE(std::getenv("ULF_BINARY"), nullptr) << "run through ctest";
  const std::string page = GetParam(), text = TextOf(Checkout() / page);
  ExampleRuns runs(page);
  std::map<std::string, std::string> printed;
  for (const Example& example : ExamplesOf(page, text))
    if (const auto output = runs.Run(example)) printed[example.command] = *output;
  std::string not_compared;
  for (const Promise& promise : kPromises) {
    if (promise.page != page) continue;
    bool compared = false;
    for (const auto& [command, output] : printed) {
      if (command.find(promise.command) == std::string::npos) continue;
      compared = true;
      const std::vector<double> said = Numbers(text, promise.promised),
                                measured = Numbers(output, promise.printed);
      ASSERT_EQ(said.size(), measured.size()) << command << " printed:\n" << output;
      for (std::size_t i = 0; i < said.size(); ++i) {
        fmt::print("  {}: says {:g}, measured {:g} (within {:.0f} %)\n", page, said[i], measured[i],
                   100 * promise.within);
        EXPECT_LE(std::abs(measured[i] - said[i]), promise.within * std::abs(said[i]))
            << page << " promises " << promise.promised << " of " << command;
      }
    }
    if (compared) continue;
    const std::string missing = runs.DataMissingFor(promise.command);
    EXPECT_NE(missing, "") << page << ": no run to compare with: " << promise.command;
    not_compared +=
        fmt::format("\n  {} (of '{}': needs the data set {})", promise.promised, promise.command, missing);
  }
  if (!not_compared.empty()) GTEST_SKIP() << page << ": promises that were not compared:" << not_compared;
}

INSTANTIATE_TEST_SUITE_P(Documents, EveryPage, ::testing::ValuesIn(Pages()), [](const auto& page) {
  std::string name = page.param;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
});

#endif

}  // namespace
}  // namespace ulf::test
