// Tests: coverage/measured/error_meter, coverage/measured/threshold_by_errors,
// commands/capture/capture_report.
//
// ulf capture measures at its frames how well the recorded views predict them, keeps it, and
// may record by it.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::measured_capture_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::CommandResult;
using test::RunUlf;
using test::ScratchFolder;
using testing::HasSubstr;

CommandResult Capture(const fs::path& dir, const std::string& more) {
  return RunUlf(
      "capture 'sim:studio?width=320&height=240&look_away=0&row_deg=4&speed_deg_s=20&cap=20x12' --headless "
      "--poses "
      "known "
      "--subject 0,0,0.07,0.162 --json --deterministic -o " +
      dir.string() + " " + more);
}

// By the bound every disc of the map gets a view. The pictures are as good as asked for with fewer.
TEST(MeasuredCapture, RecordsFewerViewsOfGoodPictures) {
  const ScratchFolder scratch;
  const CommandResult bound = Capture(scratch / "bound", "--until-covered 14x8 --no-geometry");
  ASSERT_EQ(bound.exit_code, 0) << bound.errors;
  const CommandResult measured =
      Capture(scratch / "measured",
              "--until-covered 14x8 --cover measured:29 --error-map " + (scratch / "errors.png").string());
  ASSERT_EQ(measured.exit_code, 0) << measured.errors;
  const json by_bound = JsonFromText(bound.output), by_measure = JsonFromText(measured.output);
  EXPECT_EQ(by_measure["stopped_because"], "covered");
  EXPECT_GE(by_measure["covered"], 0.98);
  EXPECT_LT(by_measure["covered_by_bound"], 0.9);
  EXPECT_LT(by_measure["recorded"].get<int>(), 0.6 * by_bound["recorded"].get<int>());
  EXPECT_EQ(by_measure["measured"]["cover"], "measured");
  EXPECT_EQ(by_measure["measured"]["goal_db"], 29);
  EXPECT_GT(by_measure["measured"]["directions"], 30);
  EXPECT_GE(by_measure["measured"]["median_db"], 29);
  EXPECT_GT(by_measure["ms_measure_median"], 0);
  const cv::Mat picture = cv::imread((scratch / "errors.png").string());
  EXPECT_EQ(picture.cols, 960);

  // It is kept with the light field, and told again.
  const LightField light_field = ReadLightField(scratch / "measured");
  ASSERT_TRUE(light_field.measured);
  EXPECT_EQ(light_field.measured->directions.size(), by_measure["measured"]["directions"]);
  const CommandResult info = RunUlf("info " + (scratch / "measured").string() + " --json");
  ASSERT_EQ(info.exit_code, 0) << info.errors;
  EXPECT_EQ(JsonFromText(info.output)["measured"], by_measure["measured"]);
  EXPECT_NEAR(JsonFromText(info.output)["covered"], by_measure["covered"], 0.02);
  const CommandResult words = RunUlf("info " + (scratch / "measured").string());
  EXPECT_THAT(words.output, HasSubstr("as measured"));
  EXPECT_THAT(words.output, HasSubstr("dB, in the worst tenth"));
}

TEST(MeasuredCapture, MeasuresErrorsWhenTheBoundDecides) {
  const ScratchFolder scratch;
  const std::string frames = "--frames 50";
  const CommandResult with = Capture(scratch / "with", frames);
  ASSERT_EQ(with.exit_code, 0) << with.errors;
  const CommandResult without = Capture(scratch / "without", frames + " --no-geometry");
  ASSERT_EQ(without.exit_code, 0) << without.errors;
  EXPECT_EQ(JsonFromText(with.output)["recorded"], JsonFromText(without.output)["recorded"]);
  EXPECT_TRUE(JsonFromText(without.output)["measured"].is_null());
}

TEST(MeasuredCapture, SaysThatOnlyTheBoundDecided) {
  const ScratchFolder scratch;
  const CommandResult run = Capture(scratch / "lf", "--frames 3 --cover measured");
  EXPECT_THAT(run.errors, HasSubstr("no errors were measured"));
  EXPECT_THAT(run.errors, HasSubstr("the bound alone decided"));
}

TEST(MeasuredCapture, ResumesWithoutTakenBackMeasures) {
  const ScratchFolder scratch;
  ASSERT_EQ(Capture(scratch / "lf", "--frames 90 --until-covered 40x20 --cover measured:29").exit_code, 0);
  const auto before = ReadLightField(scratch / "lf").measured;
  ASSERT_TRUE(before);
  ASSERT_GT(before->directions.size(), 20u);
  const CommandResult again = Capture(scratch / "lf", "--resume --frames 20 --cover measured:29");
  ASSERT_EQ(again.exit_code, 0) << again.errors;
  const LightField after = ReadLightField(scratch / "lf");
  ASSERT_TRUE(after.measured);
  EXPECT_GE(after.measured->directions.size(), before->directions.size());
  EXPECT_GE(after.measured->frames, before->frames);

  std::ofstream(scratch / "lines") << "take-back " << after.views.size() - 3 << "\n";
  const CommandResult less =
      Capture(scratch / "lf", "--resume --frames 2 --requests " + (scratch / "lines").string());
  ASSERT_EQ(less.exit_code, 0) << less.errors;
  const LightField left = ReadLightField(scratch / "lf");
  EXPECT_LT(left.views.size(), after.views.size());
  EXPECT_LT(left.measured->directions.size(), after.measured->directions.size() / 2);
}

TEST(MeasuredCapture, LeavesOutUnreadablePhotographs) {
  const ScratchFolder scratch;
  ASSERT_EQ(Capture(scratch / "lf", "--frames 60 --until-covered 40x20").exit_code, 0);
  const LightField before = ReadLightField(scratch / "lf");
  ASSERT_GT(before.views.size(), 6u);
  std::size_t damaged = 0;
  for (const char* folder : {"images", "masters"})
    for (const auto& file : fs::directory_iterator(scratch / "lf" / folder))
      if (file.is_regular_file() && file.path().stem().string() < "000004") {
        fs::resize_file(file, fs::file_size(file) / 2);
        ++damaged;
      }
  ASSERT_GE(damaged, 2u);
  const CommandResult again =
      Capture(scratch / "lf", "--resume --until-covered none --frames 120 --cover measured:29");
  ASSERT_EQ(again.exit_code, 0) << again.errors;
  const json report = JsonFromText(again.output);
  EXPECT_GT(report["recorded"], 0) << "views were recorded after the damaged ones were met";
  EXPECT_GT(report["measured"]["directions"], 0) << "by the other views";
}

TEST(MeasuredCapture, OptionsThatContradictAreRefused) {
  const ScratchFolder scratch;
  const CommandResult without = Capture(scratch / "a", "--cover measured --no-geometry");
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.errors, HasSubstr("--no-geometry"));
  const CommandResult nonsense = Capture(scratch / "b", "--cover luck");
  EXPECT_EQ(nonsense.exit_code, 2);
  EXPECT_THAT(nonsense.errors, HasSubstr("bound, measured or both"));
  const CommandResult picture =
      Capture(scratch / "c", "--no-geometry --error-map " + (scratch / "c.png").string());
  EXPECT_EQ(picture.exit_code, 2);
  EXPECT_THAT(picture.errors, HasSubstr("--error-map and --no-geometry"));
  EXPECT_FALSE(fs::exists(scratch / "c"));
  EXPECT_FALSE(fs::exists(scratch / "a"));
  EXPECT_FALSE(fs::exists(scratch / "b"));
}

}  // namespace
}  // namespace ulf::measured_capture_test
