// Tests: commands/about/about_commands, commands/about/command_tree, commands/about/completion,
// commands/about/manual, commands/options/option_values.
//
// What an installation brings beside the program, asked of the shells and the readers of man pages that it is
// for. A shell that is not installed is skipped, and said.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/base/atomic_file.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::test::about_test {
namespace {
namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Key;
using ::testing::Not;
using ::testing::StartsWith;

// Both outputs of a line of sh.
std::string Said(const std::string& line) {
  FILE* pipe = popen(("{ " + line + "\n} 2>&1").c_str(), "r");
  std::string said;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) said += static_cast<char>(c);
  pclose(pipe);
  return said;
}

bool Installed(const std::string& program) { return !Said("command -v " + program).empty(); }

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

// "-o,--output TEXT REQUIRED   Folder" gives -o and --output.
std::vector<std::string> OptionsInHelp(const std::string& help) {
  std::vector<std::string> names;
  for (const std::string& line : LinesOf(help)) {
    if (!line.starts_with("  -")) continue;
    std::istringstream list(line.substr(2, line.find(' ', 2) - 2));
    for (std::string name; std::getline(list, name, ',');)
      names.push_back(name.substr(0, name.find('{')));  // --no-check{false}: what it sets
  }
  return names;
}

// "  capture   Capture a light field" below "Subcommands:" gives capture, "  gltf, blender   ..." gltf.
std::vector<std::string> CommandsInHelp(const std::string& help) {
  std::vector<std::string> names;
  bool listed = false;
  for (const std::string& line : LinesOf(help)) {
    if (line.starts_with("Subcommands:"))
      listed = true;
    else if (!line.starts_with("  "))
      listed = false;
    else if (listed && line[2] != ' ')
      names.push_back(line.substr(2, line.find_first_of(" ,", 2) - 2));
  }
  return names;
}

// Every command by its words, the program itself first, with its help.
std::vector<std::pair<std::string, std::string>> AllCommands() {
  std::vector<std::pair<std::string, std::string>> all{{"", RunUlf("--help").output}};
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const std::string& name : CommandsInHelp(all[i].second)) {
      const std::string command = all[i].first.empty() ? name : all[i].first + " " + name;
      all.emplace_back(command, RunUlf(command + " --help").output);
    }
  return all;
}

fs::path PageOf(const ScratchFolder& folder, std::string command) {
  for (char& c : command)
    if (c == ' ') c = '-';
  return folder / ("ulf" + (command.empty() ? "" : "-" + command) + ".1");
}

TEST(Version, TellsTheLibrariesAndTheRenderer) {
  EXPECT_THAT(RunUlf("--version").output, ::testing::Not(HasSubstr("OpenGL")));
  const CommandResult result = RunUlf("--verbose --version");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, StartsWith("ulf "));
  EXPECT_THAT(result.output, ::testing::ContainsRegex("OpenCV [0-9]+\\.[0-9]+"));
  for (const char* name :
       {"Aravis", "libgphoto2", "LibRaw", "GLFW", "OpenGV", "Ceres", "CGAL", "OpenEXR", "Dear ImGui"})
    EXPECT_THAT(result.output, ::testing::ContainsRegex(std::string(name) + " [0-9]")) << name;
  EXPECT_THAT(result.output, HasSubstr("\nOpenGL: "));
}

// Loading and binding libraries is what a start costs. Those of pictures and videos that OpenCV brings are a
// hundred and more, FFmpeg's another hundred, loaded when a video is read.
TEST(Version, StartLoadsNoVideoOrPictureLibraries) {
  const std::string libraries = Said("ldd \"$ULF_BINARY\"");
  EXPECT_THAT(libraries, HasSubstr("libopencv_core"));
  for (const char* name : {"libopencv_imgcodecs", "libopencv_videoio", "libopencv_highgui", "libavcodec",
                           "libavformat", "libgdal", "libQt", "libLLVM"})
    EXPECT_THAT(libraries, ::testing::Not(HasSubstr(name)));
  constexpr int kMost = 100;  // 88 on Debian 12, where 260 were before
  EXPECT_LE(std::ranges::count(libraries, '\n'), kMost) << libraries;
}

// What they cost. An eighth of the instructions, and a quarter of the memory, of the program that loaded them
// all (901.6 million and 140,500 kB on Debian 12) were asked for.
TEST(Version, AStartTakesFewInstructionsAndLittleMemory) {
  if (kIsSanitized) GTEST_SKIP() << "a sanitizer has instructions and memory of its own";
  const ScratchFolder scratch;
  const std::string counted =
      Said("valgrind --tool=callgrind --callgrind-out-file=" + (scratch / "out").string() +
           " \"$ULF_BINARY\" --version");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(counted, found, std::regex("Collected : ([0-9]+)"))) << counted;
  constexpr double kMostInstructions = 112.7e6;  // 83.4 million on Debian 12
  EXPECT_LE(std::stod(found[1]), kMostInstructions);

  const pid_t child = fork();
  if (child == 0) {
    freopen("/dev/null", "w", stdout);
    execl(std::getenv("ULF_BINARY"), "ulf", "--version", nullptr);
    _exit(127);
  }
  int status = 0;
  rusage used{};
  ASSERT_EQ(wait4(child, &status, 0, &used), child);
  ASSERT_EQ(status, 0);
  constexpr long kMostKilobytes = 35100;  // 31,676 on Debian 12, where 140,500 were before
  EXPECT_LE(used.ru_maxrss, kMostKilobytes);
}

// Of the display, and of the window; the pages are named, too.
TEST(Help, ListsTheKeys) {
  EXPECT_THAT(
      RunUlf("capture --help").output,
      AllOf(HasSubstr("docs/capture.md"),
            ::testing::ContainsRegex("\n  Backspace +take back the last view\n"),
            ::testing::ContainsRegex("In the review:\n(.*\n)*  Delete +take back the marked view\n")));
  EXPECT_THAT(RunUlf("view --help").output,
              AllOf(HasSubstr("docs/rendering.md#viewer"),
                    ::testing::ContainsRegex("\n  F, 1 to 6 +blending field\n")));
}

TEST(Version, IsToldWithoutOpenGl) {
  const WithoutOpenGl machine;
  const CommandResult result = RunUlf("--verbose --version");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, AllOf(StartsWith("ulf "), HasSubstr("OpenGL: none: ")));
}

TEST(Manual, HasEveryCommandWithEveryOption) {
  const ScratchFolder folder;
  const CommandResult result = RunUlf("manual " + folder.path().string());
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const std::vector<std::pair<std::string, std::string>> commands = AllCommands();
  EXPECT_THAT(commands,
              AllOf(Contains(Key("capture")), Contains(Key("export colmap")), Not(Contains(Key("manual")))));
  for (const auto& [command, help] : commands) {
    std::string page = ReadWholeFile(PageOf(folder, command));
    ASSERT_FALSE(page.empty()) << PageOf(folder, command);
    for (const char* section : {"NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXIT STATUS", "SEE ALSO"})
      EXPECT_THAT(page, HasSubstr(std::string(".SH ") + section + "\n")) << command;
    std::string plain;
    for (const char c : page)
      if (c != '\\') plain += c;
    const std::vector<std::string> options = OptionsInHelp(help);
    EXPECT_THAT(options, Contains("--help")) << command;
    for (const std::string& option : options) EXPECT_THAT(plain, HasSubstr("fB" + option + "fR")) << command;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()),
            static_cast<std::ptrdiff_t>(commands.size()));
}

TEST(Manual, FolderThatIsNotThereIsWrongUsage) { EXPECT_EQ(RunUlf("manual /nowhere/at/all").exit_code, 2); }

TEST(Manual, HasNothingThatMandocWarnsOf) {
  if (!Installed("mandoc")) GTEST_SKIP() << "mandoc is not installed";
  const ScratchFolder folder;
  ASSERT_EQ(RunUlf("manual " + folder.path().string()).exit_code, 0);
  // Pages carry no date: they depend on the program alone.
  const std::string said =
      Said("mandoc -T lint -W warning " + folder.path().string() + "/*.1 | grep -v 'missing date'");
  EXPECT_EQ(said, "");
  EXPECT_THAT(Said("mandoc -T ascii " + (folder / "ulf-capture.1").string() + " | col -b"),
              AllOf(HasSubstr("--until-covered TEXT"), HasSubstr("ulf capture sim:studio -o studio")));
}

TEST(Manual, HasNothingThatGroffWarnsOf) {
  if (!Installed("groff")) GTEST_SKIP() << "groff is not installed";
  const ScratchFolder folder;
  ASSERT_EQ(RunUlf("manual " + folder.path().string()).exit_code, 0);
  for (const auto& page : fs::directory_iterator(folder.path()))
    EXPECT_EQ(Said("groff -man -ww -z -T utf8 " + page.path().string()), "") << page.path();
}

TEST(Completion, ForAnUnknownShellIsWrongUsage) {
  const CommandResult result = RunUlf("completion tcsh");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, AllOf(HasSubstr("tcsh"), HasSubstr("bash, zsh and fish")));
}

// A line as it is typed, the cursor at its end.
struct Typed {
  std::vector<std::string> words;  // after "ulf"; the last one is being typed
  std::vector<std::string> offered, not_offered;
};

const std::vector<Typed>& Lines() {
  static const std::vector<Typed> lines{
      {{"cap"}, {"capture"}, {"render"}},
      {{""}, {"capture", "view", "export"}, {"manual", "colmap", "--quality"}},
      {{"capture", "--qual"}, {"--quality"}, {"--headless", "--fov-deg"}},
      {{"capture", "--quality", ""}, {"high", "fast"}, {"auto", "capture"}},
      {{"render", "vase", "--renderer", "r"}, {"reference"}, {"gl"}},
      {{"track", "--intrinsics", ""}, {"fixed", "check", "refine"}, {}},
      {{"render", "vase", "--path", ""}, {"orbit", "spiral", "some_folder"}, {"FILE"}},
      {{"render", "vase", "--field", ""}, {"auto", "lumigraph-per-pixel"}, {"some_folder"}},
      {{"view", "vase", "--proxy", "p"}, {"plane", "planes", "points"}, {"mesh"}},
      {{"capture", "sim:studio", "--operator", ""}, {"guided", "unguided-novice"}, {"some_folder"}},
      {{"track", "--poses", ""}, {"features", "known"}, {"some_folder"}},
      {{"export", ""}, {"colmap", "nerfstudio"}, {"capture"}},
      {{"export", "colmap", "--un"}, {"--undistort"}, {"--until-covered"}},
      {{"info", "some_f"}, {"some_folder"}, {"other_folder"}},
  };
  return lines;
}

// What a shell offers for each of the lines; `ask` makes the shell's own command that prints one a line.
template <typename Ask>
void ExpectOffers(Ask&& ask) {
  for (const Typed& line : Lines()) {
    std::string words;
    for (const std::string& word : line.words) words += " " + word;
    std::set<std::string> offered;
    const std::string said = ask(line.words);
    for (std::string name : LinesOf(said)) {
      name = name.substr(0, name.find_first_of("\t/"));
      while (name.ends_with(' ')) name.pop_back();
      offered.insert(name);
    }
    for (const std::string& name : line.offered)
      EXPECT_THAT(offered, Contains(name)) << words << "\n" << said;
    for (const std::string& name : line.not_offered)
      EXPECT_THAT(offered, Not(Contains(name))) << words << "\n" << said;
  }
}

// A folder with the script and two folders to complete.
std::string WithFolders(const ScratchFolder& folder, const std::string& shell) {
  const CommandResult script = RunUlf("completion " + shell);
  EXPECT_EQ(script.exit_code, 0);
  std::ofstream(folder / "script") << script.output;
  fs::create_directory(folder / "some_folder");
  fs::create_directory(folder / "other_folder");
  return "cd " + folder.path().string();
}

TEST(Completion, CompletesInBash) {
  if (!Installed("bash")) GTEST_SKIP() << "bash is not installed";
  const ScratchFolder folder;
  const std::string begin = WithFolders(folder, "bash");
  ExpectOffers([&](const std::vector<std::string>& words) {
    std::string list = "ulf";
    for (const std::string& word : words) list += " \"" + word + "\"";
    return Said(begin + " && bash -c '. ./script; COMP_WORDS=(" + list + "); COMP_CWORD=" +
                std::to_string(words.size()) + "; _ulf; printf \"%s\\n\" \"${COMPREPLY[@]}\"'");
  });
}

TEST(Completion, CompletesInFish) {
  if (!Installed("fish")) GTEST_SKIP() << "fish is not installed";
  const ScratchFolder folder;
  const std::string begin = WithFolders(folder, "fish") + " && export HOME=$PWD";
  ExpectOffers([&](const std::vector<std::string>& words) {
    std::string line = "ulf";
    for (const std::string& word : words) line += " " + word;
    return Said(begin + " && fish -c 'source ./script; complete -C \"" + line + "\"'");
  });
}

// zsh completes at a prompt only: one is made in a terminal of its own (zpty), and what it would
// list is printed.
TEST(Completion, CompletesInZsh) {
  if (!Installed("zsh")) GTEST_SKIP() << "zsh is not installed";
  const ScratchFolder folder;
  const std::string begin = WithFolders(folder, "zsh");
  std::ofstream(folder / "ask.zsh") << R"zsh(
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell "PROMPT=; autoload -U compinit; compinit -D -u; source ./script"
zpty -w shell "zstyle ':completion:*' list-grouped false; zstyle ':completion:*' verbose no; zstyle ':completion:*' list-separator ''"
# What is offered to the line editor is printed in its place.
zpty -w shell 'compadd() { local -a found; builtin compadd -O found "$@"; print -rl -- BEGIN $found END; builtin compadd "$@" }'
zpty -w shell 'LISTMAX=10000; print READY'
zpty -r shell line '*READY*READY*'
zpty -w -n shell "$1"$'\t'
sleep 0.01
zpty -w -n shell $'\C-u'
zpty -w shell "print DONE-\$((1+1))"
zpty -r shell line '*DONE-2*'
print -r -- "$line" | tr -d '\r' | sed -n '/BEGIN$/,/^END/p'
)zsh";
  ExpectOffers([&](const std::vector<std::string>& words) {
    std::string line = "ulf";
    for (const std::string& word : words) line += " " + word;
    return Said(begin + " && zsh -f ask.zsh '" + line + "'");
  });
}

}  // namespace
}  // namespace ulf::test::about_test
