// Tests: commands/light_field/merge_command, commands/reports/work_reports,
// commands/reports/light_field_report.
//
// ulf capture --bracket and ulf merge, as a person meets them.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/json_text.h"
#include "core/image/files/exr_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/support/test_paths.h"

namespace ulf::test::merge_command_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kDevice[] =
    "'sim:lightbox?width=320&height=240&fps=30&format=bayerrg12&exposure_us=1000&speed_deg_s=5&look_away=0'";

TEST(MergeCommand, MergesABracketedCaptureAgain) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string();
  const CommandResult capture = RunUlf(
      std::string("capture ") + kDevice + " -o " + dir +
      " --headless --deterministic --no-geometry --quality fast --max-seconds 5 --bracket 3x2EV --json");
  ASSERT_EQ(capture.exit_code, 0) << capture.errors;
  const auto report = JsonFromText(capture.output);
  const LightField light_field = ReadLightField(dir);
  ASSERT_GE(light_field.views.size(), 2u);
  EXPECT_EQ(report.at("brackets").at("views"), light_field.views.size());
  EXPECT_GE(report.at("merged").at("views"), light_field.views.size() - 1) << "the last one may be cut off";
  EXPECT_NEAR(report.at("merged").at("stops").get<double>(), 4, 0.1);
  const View& view = light_field.views[0];
  ASSERT_TRUE(view.merged);
  EXPECT_EQ(view.merged->exposures, 3);
  double brightest = 0;
  cv::minMaxLoc(ReadExr((fs::path(dir) / view.merged->path).string()).reshape(1), nullptr, &brightest);
  EXPECT_GT(brightest, 2) << "beyond full scale of the view's own exposure";

  const CommandResult info = RunUlf("info " + dir + " --json");
  ASSERT_EQ(info.exit_code, 0) << info.errors;
  const auto brackets = JsonFromText(info.output).at("brackets");
  EXPECT_GE(brackets.at("views"), light_field.views.size() - 1);
  EXPECT_EQ(brackets.at("exposures").at("most"), 3);
  EXPECT_EQ(brackets.at("stops"), nlohmann::json({-2, 0, 2}));
  EXPECT_EQ(brackets.at("merged"), report.at("merged").at("views"));
  EXPECT_DOUBLE_EQ(brackets.at("ghosts_most").get<double>(),
                   report.at("merged").at("ghosts_most").get<double>());
  EXPECT_THAT(RunUlf("info " + dir).output,
              ContainsRegex("brackets +[0-9]+ views of .*-2, 0, \\+2 stops.*merged"));

  // It can be made again, by whatever geometry there is then, and the renderer takes it.
  fs::remove_all(fs::path(dir) / "merged");
  const CommandResult merge = RunUlf("merge " + dir);
  ASSERT_EQ(merge.exit_code, 0) << merge.errors;
  EXPECT_THAT(merge.output, HasSubstr("ghosts"));
  EXPECT_TRUE(fs::exists(fs::path(dir) / view.merged->path));
  EXPECT_EQ(
      RunUlf("render " + dir + " --path orbit --frames 1 --width 160 -o " + (scratch / "p.exr").string())
          .exit_code,
      0);

  // An exposure that is gone is named.
  fs::remove(fs::path(dir) / view.exposures[0].master_path);
  const CommandResult missing = RunUlf("merge " + dir);
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.errors, HasSubstr(view.exposures[0].master_path));
}

TEST(MergeCommand, RefusesWhatItCannotBracketOrMerge) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string(),
                    capture = std::string("capture ") + kDevice + " -o " + dir;
  const CommandResult nonsense = RunUlf(capture + " --headless --bracket 3EV");
  EXPECT_EQ(nonsense.exit_code, 2);
  EXPECT_THAT(nonsense.errors, HasSubstr("such as 3x2EV"));
  EXPECT_FALSE(fs::exists(dir)) << "before anything was written";
  ASSERT_EQ(RunUlf(capture + " --headless --deterministic --no-geometry --max-seconds 2 --json").exit_code,
            0);
  EXPECT_THAT(RunUlf("info " + dir).output, Not(HasSubstr("brackets")));
  const CommandResult nothing = RunUlf("merge " + dir);
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.errors, HasSubstr("capture with --bracket"));
  const CommandResult replayed = RunUlf("capture replay:" + dir + " -o " + (scratch / "again").string() +
                                        " --headless --no-geometry --bracket 3x2EV");
  EXPECT_EQ(replayed.exit_code, 2);
  EXPECT_THAT(replayed.errors, HasSubstr("cannot be asked for exposures"));
  EXPECT_FALSE(fs::exists(scratch / "again"));
}

}  // namespace
}  // namespace ulf::test::merge_command_test
