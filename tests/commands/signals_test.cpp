// Tests: commands/commands, core/light_field/exchange/staged_folder, core/base/atomic_file,
// core/base/stop_signal.
//
// SIGINT and SIGTERM at random moments of every command that writes: what it writes is as before or new,
// nothing between, and after its next run nothing temporary is left. Rows of docs/measured/cameras.md.
#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <random>
#include <regex>
#include <set>
#include <sstream>
#include <thread>

#include "commands/reports/check_reports.h"
#include "commands/reports/geometry_report.h"
#include "commands/reports/light_field_report.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/host_time.h"
#include "core/base/json_text.h"
#include "core/geometry/digest.h"
#include "core/image/files/picture_file.h"
#include "core/image/image.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/support/child_process.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::test::signals_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::IsEmpty;

constexpr const char* kCamera = "'sim:studio?width=160&height=120&seed=1&speed_deg_s=60&look_away=0'";
constexpr const char* kKnown = " --headless --no-geometry --poses known --subject 0,0,0.07,0.162";

// Where a command works: `lf` is a light field (a copy of its own each time), `out` what it makes.
struct Writer {
  const char* name;
  std::string arguments;                                      // {lf} and {out} stand for the two
  enum class Ends { kAtOnce, kInPieces, kInGoodOrder } ends;  // at a signal
  std::string next = "";                                      // what runs afterwards; empty: the same again
  std::string before = "";  // what makes {lf}, or changes it first; "cut": its journal
};

std::string Ulf() {
  const char* const binary = std::getenv("ULF_BINARY");
  return binary ? binary : "false";
}

class Workshop {
 public:
  Workshop() {
    fs::create_directory(home());
    EXPECT_EQ(
        RunUlf(fmt::format("capture {} {} --frames 30 -o {}", kCamera, kKnown, whole().string())).exit_code,
        0);
    EXPECT_EQ(RunUlf(fmt::format("export nerfstudio {} --known-points -o {}", whole().string(),
                                 (scratch_ / "set").string()))
                  .exit_code,
              0);
  }
  void Prepare(const Writer& writer) {
    if (writer.before.empty()) return;
    fs::remove_all(scratch_ / "prepared");
    if (!writer.before.starts_with("capture"))
      fs::copy(whole(), scratch_ / "prepared", fs::copy_options::recursive);
    if (writer.before == "cut") {
      const fs::path journal = scratch_ / "prepared" / "journal.jsonl";
      return fs::resize_file(journal, fs::file_size(journal) / 2);
    }
    const CommandResult made = RunUlf(Filled(writer.before, scratch_ / "prepared"));
    EXPECT_EQ(made.exit_code, 0) << made.errors;
  }
  void Begin(const Writer& writer) {
    fs::remove_all(home());
    fs::create_directory(home());
    if (writer.arguments.find("{lf}") != std::string::npos)
      fs::copy(writer.before.empty() ? whole() : scratch_ / "prepared", home() / "lf",
               fs::copy_options::recursive);
  }
  std::string Filled(std::string text, const fs::path& light_field = {}) const {
    const std::map<std::string, fs::path> names{{"{lf}", light_field.empty() ? home() / "lf" : light_field},
                                                {"{out}", home() / "out"},
                                                {"{set}", scratch_ / "set"}};
    for (const auto& [name, path] : names)
      for (std::size_t at; (at = text.find(name)) != std::string::npos;)
        text.replace(at, name.size(), path.string());
    return text;
  }
  fs::path whole() const { return scratch_ / "whole"; }
  fs::path home() const { return scratch_ / "home"; }
  fs::path errors() const { return scratch_ / "errors"; }

 private:
  ScratchFolder scratch_;
};

// A file by its bytes; "damaged: ..." where it is no picture, or no JSON, though its name says so.
std::string ContentSeen(const fs::path& file) {
  const std::string bytes = ReadWholeFile(file);
  try {
    if (file.extension() == ".png" || file.extension() == ".tif") ReadImageFile(file.string());
    if (file.extension() == ".json") JsonFromText(bytes);
  } catch (const std::exception& error) {
    return std::string("damaged: ") + error.what();
  }
  return fmt::format("{} bytes, {}", bytes.size(), ChecksumText(ChecksumOf(bytes)));
}

// What a stranger sees of a folder: of a light field what `ulf info` tells, else all files.
std::string Seen(const fs::path& path) {
  if (fs::exists(path / "journal.jsonl")) {
    try {
      const LightField light_field = ReadLightField(path);
      nlohmann::json told = commands::ToJson(commands::Describe(light_field, {}));
      told["geometry"] = commands::GeometryJson(render::GeometryStateOf(light_field));
      told["doubts"] = commands::DoubtsJson(light_field);
      std::string info = JsonText(told);
      for (const std::string& doubt : light_field.doubts) info += "doubts: " + doubt;
      return info;
    } catch (const std::exception& error) {
      return std::string("damaged: ") + error.what();
    }
  }
  if (!fs::exists(path)) return "nothing";
  if (fs::is_regular_file(path)) return ContentSeen(path);
  std::string files;
  std::set<std::string> sorted;
  for (const auto& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) sorted.insert(fs::relative(entry.path(), path).string());
  for (const std::string& name : sorted) files += name + ": " + ContentSeen(path / name) + "\n";
  return files.empty() ? "nothing" : files;
}

std::string Seen(const Workshop& shop) {
  std::string seen;
  for (const char* name : {"lf", "out", "out.pdf", "out.mp4", "out.json", "out.png", "out.ply", "out.tum"})
    seen += Seen(shop.home() / name);
  return seen;
}

bool IsOpen(const fs::path& path) {
  return fs::exists(path / "journal.jsonl") &&
         ReadWholeFile(path / "journal.jsonl").find("\"event\":\"close\"") == std::string::npos;
}

std::vector<std::string> Litter(const fs::path& path) {
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    const std::string name = entry.path().filename().string();
    if (name.find(kTemporaryEnding) != std::string::npos || name.starts_with("."))
      found.push_back(fs::relative(entry.path(), path).string());
  }
  return found;
}

struct Counts {
  std::string names;
  int tried = 0, between = 0;
  double longest_s = 0;  // of the next runs
};

void Try(const Writer& writer, Workshop& shop, std::mt19937& random, Counts& counts) {
  shop.Prepare(writer);
  shop.Begin(writer);
  const std::string before = Seen(shop);
  const auto begin = std::chrono::steady_clock::now();
  const CommandResult undisturbed = RunUlf(shop.Filled(
      writer.arguments + (writer.arguments.find("sim:studio") == std::string::npos ? "" : " --frames 60")));
  const double whole_s = SecondsSince(begin);
  EXPECT_EQ(undisturbed.exit_code, 0) << writer.name << ": " << undisturbed.errors;
  const std::string after = Seen(shop);
  counts.names += (counts.names.empty() ? "" : ", ") + std::string(writer.name);
  for (int i = 0; i < TRIES; ++i)
    for (const int signal : {SIGINT, SIGTERM}) {
      const std::string at = fmt::format("{}, try {} of signal {}", writer.name, i, signal);
      shop.Begin(writer);
      ChildProcess child({"/bin/sh", "-c",
                          fmt::format("exec env --default-signal=INT {} {} >/dev/null 2>{}", Ulf(),
                                      shop.Filled(writer.arguments), shop.errors().string())});
      const double moment_s = std::uniform_real_distribution<double>(0, whole_s)(random);
      std::this_thread::sleep_for(std::chrono::duration<double>(moment_s));
      child.Signal(signal);
      const int status = child.Wait(60);
      ++counts.tried;
      EXPECT_THAT(status, AnyOf(0, 1, 128 + signal)) << at << ReadWholeFile(shop.errors());
      const std::string now = Seen(shop);
      const bool damaged = now.find("damaged: ") != std::string::npos ||
                           now.find("doubts: ") != std::string::npos ||
                           (status == 0 && IsOpen(shop.home() / "out"));
      const bool is_between = writer.ends == Writer::Ends::kAtOnce ? now != before && now != after : damaged;
      counts.between += is_between;
      EXPECT_FALSE(is_between) << at << "\nbefore: " << before << "\nafter: " << after << "\nnow: " << now;
      const auto again = std::chrono::steady_clock::now();
      RunUlf(shop.Filled(writer.next.empty() ? writer.arguments : writer.next));
      counts.longest_s = std::max(counts.longest_s, SecondsSince(again));
      EXPECT_THAT(Litter(shop.home()), IsEmpty()) << at;
      const std::string then = Seen(shop);
      if (writer.next.empty()) {
        EXPECT_EQ(then, after) << at;
      }
    }
}

std::vector<Writer> Writers() {
  using Ends = Writer::Ends;
  const std::string capture = fmt::format("capture {} {} -o ", kCamera, kKnown);
  const std::string brackets =
      "capture 'sim:studio?width=160&height=120&fps=10&speed_deg_s=30&look_away=0&exposure_us=2000&noise=0' "
      "--headless --no-geometry --poses known --subject 0,0,0.07,0.17 --bracket 3x2EV --frames 24 -o {lf}";
  std::vector<Writer> writers{
      {"`ulf capture`", capture + "{out}", Ends::kInGoodOrder, capture + "{out} --resume --frames 5"},
      {"`ulf capture --resume`", capture + "{lf} --resume", Ends::kInGoodOrder,
       capture + "{lf} --resume --frames 5"},
      {"`ulf record`", fmt::format("record {} -o {{out}}", kCamera), Ends::kInGoodOrder,
       "record sim:studio -o {out} --frames 2"},
      {"`ulf import`", "import {set} -o {out} --no-check", Ends::kAtOnce},
      {"`ulf take-back`", "take-back {lf} 3", Ends::kAtOnce, "take-back {lf} 5"},
      {"`ulf repair`", "repair {lf} --write", Ends::kAtOnce, "", "cut"},
      {"`ulf merge`", "merge {lf}", Ends::kAtOnce, "", brackets},
      {"`ulf export colmap`", "export colmap {lf} --known-points -o {out}", Ends::kAtOnce},
      {"`ulf export nerfstudio`", "export nerfstudio {lf} --known-points --undistort -o {out}",
       Ends::kAtOnce},
      {"`ulf export metashape`", "export metashape {lf} --known-points -o {out}", Ends::kAtOnce},
      {"`ulf export quilt`",
       "export quilt {lf} --tiles 4x2 --size 320x160 --proxy plane --field linear -o {out}", Ends::kAtOnce},
      {"`ulf export web`", "export web {lf} --proxy plane -o {out}", Ends::kAtOnce},
      {"`ulf render` of pictures",
       "render {lf} --frames 4 --width 80 --height 60 --proxy plane --field linear -o {out}",
       Ends::kInPieces},
      {"`ulf render` of a video",
       "render {lf} --frames 4 --width 80 --height 60 --proxy plane --field linear -o {out}.mp4",
       Ends::kAtOnce},
      {"`ulf board`", "board -o {out}.pdf", Ends::kAtOnce},
      {"`ulf info --check-poses`", "info --check-poses {lf}", Ends::kAtOnce},
  };
  if (TRIES == 1) return writers;
  // These exports write into a folder beside the new one, as those above do.
  writers.push_back({"`ulf export instant-ngp`", "export instant-ngp {lf} -o {out}", Ends::kAtOnce});
  writers.push_back({"`ulf export nerf-synthetic`", "export nerf-synthetic {lf} -o {out}", Ends::kAtOnce});
  writers.push_back({"`ulf export realityscan`", "export realityscan {lf} -o {out}", Ends::kAtOnce});
  writers.push_back({"`ulf export gltf`", "export gltf {lf} -o {out}", Ends::kAtOnce, "",
                     "proxy {lf} --size 80 --depth-maps 6"});
  writers.push_back({"`ulf export splat`", "export splat {lf} -o {out}.spz", Ends::kAtOnce, "",
                     "proxy {lf} --size 80 --depth-maps 6"});
  writers.push_back({"`ulf refine`", "refine {lf}", Ends::kAtOnce, "refine {lf}"});
  writers.push_back({"`ulf refine -o`", "refine {lf} -o {out}", Ends::kInGoodOrder, "refine {lf} -o {out}"});
  writers.push_back({"`ulf proxy -o`", "proxy {lf} --size 80 --depth-maps 6 -o {out}.ply", Ends::kAtOnce});
  writers.push_back({"`ulf sheet`", "sheet {lf} -o {out}.png", Ends::kAtOnce});
  // These two show how long it took.
  const std::string table = "evaluate {lf} --every 9 --proxy plane --table {out}.csv";
  writers.push_back({"`ulf evaluate --table`", table, Ends::kInGoodOrder, table});
  const std::string screenshot = "view {lf} --screenshot {out}.png";
  writers.push_back({"`ulf view --screenshot`", screenshot, Ends::kInGoodOrder, screenshot});
  writers.push_back({"`ulf track`", "track 'sim:studio?width=320&height=240&seed=1' -o {out}.tum",
                     Ends::kInGoodOrder,
                     "track 'sim:studio?width=320&height=240&seed=1' --frames 9 -o {out}.tum"});
  writers.push_back({"`ulf proxy`", "proxy {lf} --size 80 --depth-maps 6", Ends::kAtOnce});
  writers.push_back({"`ulf calibrate`", "calibrate sim:board -o {out}.json", Ends::kInGoodOrder,
                     "calibrate sim:board -o {out}.json"});
  writers.push_back(
      {"`ulf mask`", "mask {lf}", Ends::kAtOnce, "",
       "capture 'sim:turntable?cap=60x10&row_deg=12&fps=3' -o {lf} --headless --no-geometry --turntable "
       "charuco:5x5:54:40:DICT_4X4_50 --quality fast --max-seconds 14"});
  return writers;
}

// What needs a marker in the hand or a person at a window writes as those do that are tried: by
// WriteFileAtomically() and PictureSink.
TEST(Signals, AreTriedOnEveryCommandThatWrites) {
  if (TRIES == 1) GTEST_SKIP() << "the everyday run leaves out the slow ones";
  const std::set<std::string> by_others{"review", "calibration"};
  std::set<std::string> tried;
  for (const Writer& writer : Writers()) tried.insert(writer.arguments.substr(0, writer.arguments.find(' ')));
  std::istringstream lines(RunUlf("--help").output);
  std::size_t looked_at = 0;
  for (std::string line; std::getline(lines, line);) {
    std::smatch name;
    if (!std::regex_match(line, name, std::regex("  ([a-z][a-z-]*)  .*"))) continue;
    ++looked_at;
    const std::string help = RunUlf(name[1].str() + " --help").output;
    if (help.find("-o,--output") == std::string::npos || by_others.contains(name[1])) continue;
    EXPECT_TRUE(tried.contains(name[1])) << "ulf " << name[1] << " writes";
  }
  EXPECT_GE(looked_at, 20u);
}

TEST(Signals, LeaveTheFormerStateOrTheNewOne) {
  Workshop shop;
  std::mt19937 random(58);
  std::map<Writer::Ends, Counts> counts;
  for (const Writer& writer : Writers()) Try(writer, shop, random, counts[writer.ends]);
  for (const auto& [ends, each] : counts) {
    EXPECT_EQ(each.between, 0) << each.names;
    PrintFaultRow("SIGINT and SIGTERM at random moments: " + each.names, each.tried,
                  fmt::format("{} times something between the former state and the new one", each.between),
                  each.longest_s);
  }
}

}  // namespace
}  // namespace ulf::test::signals_test
