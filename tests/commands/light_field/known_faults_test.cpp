// Tests: commands/reports/light_field_report, commands/reports/check_reports,
// commands/light_field/import_command, core/light_field/folder/kept_findings.
//
// What is wrong with a light field is said by every command that opens it, in the same words, until it is
// mended; of a right one nothing is said. The commands are those of the command tree.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "commands/about/command_tree.h"
#include "commands/options/subcommands.h"
#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/image/files/png_picture.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/refine/refine_views.h"

namespace ulf::test::known_faults_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kWrongPoses = "disagree with what the photographs show";
constexpr const char* kWrongPoints = "the points do not belong to the poses";
constexpr const char* kWrongSubject = "no photograph shows the middle of the subject";

// The commands whose first argument is a light field.
std::set<std::string> CommandsOnLightFields() {
  CLI::App app;
  commands::ChosenCommand chosen;
  commands::AddCommands(app, chosen);
  const commands::CommandPage tree = commands::CommandTree(app);
  std::set<std::string> names;
  for (const commands::CommandPage* page : commands::AllPages(tree)) {
    const auto first = std::ranges::find_if(page->options, &commands::OptionPage::positional);
    if (first != page->options.end() && first->text.find("ight field") != std::string::npos)
      names.insert(page->FullName(" "));
  }
  return names;
}

// What each is given besides; {} stands for a name that is new. One picture, one share: that it is said does
// not depend on how much is made.
const std::map<std::string, std::string> kArguments{
    {"ulf info", ""},
    {"ulf sheet", "-o {}.png"},
    {"ulf repair", ""},
    {"ulf take-back", "99"},  // there is none: nothing is changed
    {"ulf refine", "--max-side 320 -o {}"},
    {"ulf review", "replay:/dev/null --markers marker:80:DICT_APRILTAG_36h11:3 -o {}"},
    {"ulf render", "--size-limit 160 --proxy plane --field nearest --width 64 --height 48 -o {}.png"},
    {"ulf evaluate", "--size-limit 160 --every 4 --proxy plane --fields nearest"},
    {"ulf view", "--size-limit 160 --proxy plane --width 64 --height 64 --screenshot {}.png"},
    {"ulf mask", ""},
    {"ulf merge", ""},
    {"ulf proxy", "--size 64 --depth-maps 2 -o {}.ply"},
    {"ulf export colmap", "--known-points -o {}"},
    {"ulf export nerfstudio", "--known-points -o {}"},
    {"ulf export instant-ngp", "-o {}"},
    {"ulf export nerf-synthetic", "-o {}"},
    {"ulf export realityscan", "-o {}"},
    {"ulf export metashape", "--known-points -o {}"},
    {"ulf export gltf", "-o {}"},
    {"ulf export tum", "-o {}.txt"},
    {"ulf export ply", "--known-points -o {}.ply"},
    {"ulf export splat", "-o {}.ply"},
    {"ulf export quilt", "--size-limit 160 --proxy plane --field nearest --tiles 2x1 --size 64x64 -o {}"},
    {"ulf export web", "--size-limit 160 --proxy plane --budget 200kB -o {}"},
};

class KnownFaults : public testing::Test {
 protected:
  // As another program writes them: photographs, transforms.json, points without observations.
  void WriteSet(const std::vector<int>& shown_by, double points_scale) {
    const auto views = MakeViews(8, 0, 0, 4);
    LightField set;
    set.root = set_;
    set.cameras = views->input.lenses;
    fs::create_directories(set_ / "images");
    for (std::size_t v = 0; v < views->truth.size(); ++v) {
      View& view = set.views.emplace_back();
      view.id = static_cast<int>(v) + 1;
      view.image_path = fmt::format("images/{}.png", v + 1);
      view.cam_from_world = views->truth[v];
      const Image& image = views->images[static_cast<std::size_t>(shown_by[v])];
      WriteFileAtomically(set_ / view.image_path, PngBytes(Srgb8(image)));
    }
    nlohmann::json document = TransformsDocument(set, {});
    document.erase("ulf");
    for (nlohmann::json& frame : document["frames"]) frame.erase("ulf");
    document["ply_file_path"] = "points.ply";
    WriteFileAtomically(set_ / kTransformsFile, JsonText(document));
    // On the wall and the panels before the cameras.
    std::string points;
    int count = 0;
    for (double x = -1; x <= 1; x += 0.25)
      for (double y = -0.75; y <= 0.75; y += 0.25, ++count)
        points += fmt::format("{} {} {}\n", points_scale * x, points_scale * y, points_scale * 3.0);
    WriteFileAtomically(set_ / "points.ply",
                        fmt::format("ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\n"
                                    "property float y\nproperty float z\nend_header\n{}",
                                    count, points));
  }
  CommandResult Run(const std::string& command) {
    const std::string made = (scratch_ / fmt::format("made{}", ++made_)).string();
    std::string arguments = kArguments.at(command);
    if (const std::size_t at = arguments.find("{}"); at != std::string::npos) arguments.replace(at, 2, made);
    return RunUlf(command.substr(std::string("ulf ").size()) + " " + Dir() + " " + arguments);
  }
  std::string Dir() const { return dir_.string(); }
  ScratchFolder scratch_;
  fs::path set_ = scratch_ / "set", dir_ = scratch_ / "field";
  int made_ = 0;
};

TEST_F(KnownFaults, TheListNamesEveryCommandOnLightFields) {
  std::set<std::string> listed;
  for (const auto& [command, arguments] : kArguments) listed.insert(command);
  EXPECT_EQ(listed, CommandsOnLightFields());
}

TEST_F(KnownFaults, NoCommandNamesAnyForARightSet) {
  WriteSet({0, 1, 2, 3, 4, 5, 6, 7}, 1);
  const CommandResult imported = RunUlf("import " + set_.string() + " -o " + Dir());
  ASSERT_EQ(imported.exit_code, 0) << imported.errors;
  for (const auto& [command, arguments] : kArguments)
    EXPECT_THAT(Run(command).errors, AllOf(Not(HasSubstr(kWrongPoses)), Not(HasSubstr(kWrongPoints)),
                                           Not(HasSubstr(kWrongSubject))))
        << command;
  const auto info = JsonFromText(RunUlf("info " + Dir() + " --json").output);
  EXPECT_EQ(info["doubts"], nlohmann::json::array());
  EXPECT_TRUE(info["capture_s"].is_null()) << "unknown, as the text says";
}

TEST_F(KnownFaults, EveryCommandSaysThem) {
  WriteSet({0, 1, 5, 3, 4, 2, 6, 7}, 0.001);
  const CommandResult imported = RunUlf("import " + set_.string() + " --subject 0,0,3,0.5 -o " + Dir());
  ASSERT_EQ(imported.exit_code, 0) << imported.errors;
  EXPECT_THAT(imported.errors, AllOf(HasSubstr(kWrongPoses), HasSubstr(kWrongPoints),
                                     HasSubstr("views 3 and 6 (images/3.png, images/6.png)")));
  LightFieldWriter::Resume(dir_).SetSubject({{0, 0, -500}, 0.5});
  for (const auto& [command, arguments] : kArguments) {
    const std::string said = Run(command).errors;
    for (const char* fault : {"views 3 and 6", kWrongPoses, kWrongPoints, kWrongSubject})
      EXPECT_THAT(said, HasSubstr(fault)) << command;
  }
  std::set<std::string> kinds;
  std::size_t views = 0;
  const auto info = JsonFromText(RunUlf("info " + Dir() + " --json").output);
  for (const auto& doubt : info["doubts"]) {
    kinds.insert(doubt["kind"].get<std::string>());
    views += doubt["views"].size();
    EXPECT_FALSE(doubt["words"].get<std::string>().empty());
  }
  EXPECT_THAT(kinds, ElementsAre("points", "poses", "subject"));
  EXPECT_EQ(views, 2u) << "those that were exchanged";
}

TEST_F(KnownFaults, EndWithTheExchangeOfPhotographs) {
  WriteSet({0, 1, 2, 3, 4, 5, 6, 7}, 1);
  ASSERT_EQ(RunUlf("import " + set_.string() + " -o " + Dir()).exit_code, 0);
  const auto exchange = [&] {
    fs::rename(dir_ / "images/3.png", dir_ / "images/other.png");
    fs::rename(dir_ / "images/6.png", dir_ / "images/3.png");
    fs::rename(dir_ / "images/other.png", dir_ / "images/6.png");
  };
  const auto said = [&](const std::string& options) {
    return RunUlf("info " + Dir() + " " + options).errors;
  };
  exchange();
  EXPECT_THAT(said(""), Not(HasSubstr(kWrongPoses))) << "nobody has looked yet";
  RunUlf("info " + Dir() + " --check-poses");
  EXPECT_THAT(said(""), HasSubstr("views 3 and 6"));
  exchange();
  EXPECT_THAT(said(""), Not(HasSubstr(kWrongPoses))) << "the photographs are right again";
  exchange();
  EXPECT_THAT(said(""), HasSubstr("views 3 and 6"));
  // Other poses for what the photographs show, as refine finds them, and the check runs again by itself.
  const CommandResult refined = RunUlf("refine " + Dir());
  EXPECT_EQ(refined.exit_code, 0) << refined.errors;
  EXPECT_THAT(refined.output, HasSubstr("poses          8 fit the pictures"));
  EXPECT_THAT(said(""), Not(HasSubstr(kWrongPoses)));
}

TEST_F(KnownFaults, PhotographsUnlikeMastersNameRepair) {
  WriteSet({0, 1, 2, 3, 4, 5, 6, 7}, 1);
  for (int v = 1; v <= 8; ++v) {  // of more than 8 bits: they become masters
    const std::string file = (set_ / fmt::format("images/{}.", v)).string();
    cv::Mat deep;
    cv::imread(file + "png", cv::IMREAD_COLOR).convertTo(deep, CV_16U, 257);
    cv::imwrite(file + "tif", deep);
  }
  std::string poses = ReadWholeFile(set_ / kTransformsFile);
  for (std::size_t at = 0; (at = poses.find(".png", at)) != std::string::npos;) poses.replace(at, 4, ".tif");
  WriteFileAtomically(set_ / kTransformsFile, poses);
  ASSERT_EQ(RunUlf("import " + set_.string() + " -o " + Dir()).exit_code, 0);
  fs::rename(dir_ / "images/3.png", dir_ / "images/other.png");
  fs::rename(dir_ / "images/6.png", dir_ / "images/3.png");
  fs::rename(dir_ / "images/other.png", dir_ / "images/6.png");
  const CommandResult told = RunUlf("info " + Dir() + " --check-poses");
  EXPECT_THAT(told.output,
              AllOf(HasSubstr("of views 3 and 6 differ from their masters"), HasSubstr("'ulf repair "),
                    Not(HasSubstr("finds better poses")), Not(HasSubstr("take-back"))));
  EXPECT_EQ(RunUlf("repair " + Dir() + " --write").exit_code, 0);
  EXPECT_THAT(RunUlf("info " + Dir() + " --check-poses").output, Not(HasSubstr("contradicted")));
}

TEST_F(KnownFaults, AreSaidAgainForARealSet) {
  ULF_NEED_TEST_DATA(fox, "fox_half");
  fs::copy(fox, set_, fs::copy_options::recursive);
  const LightField right = ReadLightField(set_);
  fs::rename(set_ / right.views[10].image_path, set_ / "other");
  fs::rename(set_ / right.views[30].image_path, set_ / right.views[10].image_path);
  fs::rename(set_ / "other", set_ / right.views[30].image_path);
  const CommandResult imported = RunUlf("import " + set_.string() + " -o " + Dir());
  ASSERT_EQ(imported.exit_code, 0) << imported.errors;
  for (const std::string& said :
       {imported.errors, RunUlf("info " + Dir()).errors, Run("ulf export realityscan").errors})
    EXPECT_THAT(said, AllOf(HasSubstr("views 11 and 31"), HasSubstr(kWrongPoses)));
}

}  // namespace
}  // namespace ulf::test::known_faults_test
