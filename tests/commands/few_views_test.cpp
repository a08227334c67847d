// Tests: commands/commands, commands/light_field/info_command, commands/light_field/sheet_command.
//
// Light fields that are hardly any: one view, two views, all views in one place. Every command that reads one
// serves them or says what is missing; none crashes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/test_paths.h"

namespace ulf::few_views_test {
namespace {

struct FewViews {
  const char* name;
  std::vector<Eigen::Vector3d> centers;
};

const FewViews kCases[] = {{"one view", {{0, 0, 0}}},
                           {"two views", {{0, 0, 0}, {0.1, 0, 0}}},
                           {"one place", {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}}};

void Write(const std::filesystem::path& dir, const FewViews& few) {
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(96, 72, 100);
  LightFieldWriter writer = LightFieldWriter::Create(dir, header);
  writer.SetSubject({{0, 0, 1}, 0.15});
  for (std::size_t i = 0; i < few.centers.size(); ++i) {
    Frame frame;
    frame.image.pixels.create(72, 96, CV_8UC3);
    cv::RNG random(i + 1);
    random.fill(frame.image.pixels, cv::RNG::UNIFORM, 0, 256);
    View view;
    view.cam_from_world = LookAt(few.centers[i], {0, 0, 1}, {0, -1, 0});
    writer.AddView(frame, view);
  }
  writer.Close(1);
}

TEST(FewViews, EveryCommandServesThemOrSaysWhatIsMissing) {
  for (const FewViews& few : kCases) {
    test::ScratchFolder scratch;
    const std::string dir = (scratch / "lf").string(), picture = (scratch / "p.png").string();
    Write(dir, few);

    const auto info = test::RunUlf("info " + dir + " --cap 60x40");
    EXPECT_EQ(info.exit_code, 0) << few.name << ": " << info.errors;
    EXPECT_THAT(info.output,
                testing::HasSubstr("the views span no surface: a row, a ring, or too few of them"))
        << few.name;

    for (const char* renderer : {"gl", "reference"}) {
      const auto render = test::RunUlf("render " + dir + " --renderer " + renderer + " -o " + picture);
      EXPECT_EQ(render.exit_code, 0) << few.name << " " << renderer << ": " << render.errors;
      EXPECT_THAT(render.errors, testing::HasSubstr("weights are used"))
          << few.name << ": the fallback is named";
      cv::Scalar mean, deviation;
      cv::meanStdDev(cv::imread(picture), mean, deviation);
      EXPECT_GT(deviation[0], 20) << few.name << " " << renderer << ": the photograph's noise shows";
    }

    const auto sheet = test::RunUlf("sheet " + dir + " -o " + picture);
    EXPECT_EQ(sheet.exit_code, 0) << few.name << ": " << sheet.errors;

    const auto evaluate = test::RunUlf("evaluate " + dir + " --every 2");
    if (few.centers.size() < 2) {
      EXPECT_EQ(evaluate.exit_code, 1) << few.name;
      EXPECT_THAT(evaluate.errors, testing::HasSubstr("at least two views")) << few.name;
    } else {
      EXPECT_EQ(evaluate.exit_code, 0) << few.name << ": " << evaluate.errors;
    }
  }
}

// Nine on a surface are too few to leave some out and compare: whoever draws them takes the same
// field and geometry.
TEST(FewViews, EveryoneDrawsThemByTheSameModel) {
  FewViews nine{"nine", {}};
  for (const double y : {-0.1, 0.0, 0.13})
    for (const double x : {-0.12, 0.0, 0.1}) nine.centers.emplace_back(x + 0.02 * y, y, 0);
  test::ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string(), picture = (scratch / "p.png").string();
  Write(dir, nine);
  const auto told = [](const std::string& command) {
    const auto result = test::RunUlf(command);
    EXPECT_EQ(result.exit_code, 0) << command << ": " << result.errors;
    return JsonFromText(result.output);
  };
  const auto render = told("render " + dir + " --json -o " + picture);
  EXPECT_EQ(render["field"], "lumigraph");
  const auto evaluate = told("evaluate " + dir + " --every 4 --fields nearest --json")["default"];
  const auto view = told("view " + dir + " --screenshot " + picture + " --json");
  const auto web = told("export web " + dir + " -o " + (scratch / "site").string() + " --json");
  for (const auto& other : {evaluate, view, web}) {
    EXPECT_EQ(other["field"], render["field"]);
    EXPECT_EQ(other["proxy"], render["proxy"]);
  }
  const std::string page = ReadWholeFile(scratch / "site/data/scene.js");
  EXPECT_THAT(page, testing::Not(testing::HasSubstr("firstWeight"))) << "the page has no mesh to draw over";
}

TEST(FewViews, NoneAtAllIsAnError) {
  test::ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string();
  Write(dir, {"none", {}});
  EXPECT_EQ(test::RunUlf("info " + dir).exit_code, 0) << "an empty capture can be looked at";
  for (const char* command : {"render ", "evaluate ", "sheet "}) {
    const auto result = test::RunUlf(
        command + dir + (std::string(command) == "evaluate " ? "" : " -o " + (scratch / "p.png").string()));
    EXPECT_EQ(result.exit_code, 1) << command;
    EXPECT_THAT(result.errors, testing::HasSubstr("no views")) << command;
  }
}

// The thesis's Table 6.1.
TEST(FewViews, SeveralLightFieldsAreATableWithARowEach) {
  test::ScratchFolder scratch;
  const std::string one = (scratch / "one").string(), two = (scratch / "two").string(),
                    none = (scratch / "none").string();
  Write(one, kCases[0]);
  Write(two, kCases[1]);
  const auto table = test::RunUlf("info " + one + " " + two);
  ASSERT_EQ(table.exit_code, 0) << table.errors;
  EXPECT_THAT(table.output,
              testing::ContainsRegex("light field +views +capture time, min +angular range, degrees "
                                     "+average angle, degrees\n.*one +1 +0.0 +0x0 +-\n.*two +2 "
                                     "+0.0 +6x0 +-\n$"));
  const auto json = test::RunUlf("info " + one + " " + two + " --cap 10x10 --json");
  EXPECT_THAT(json.output, testing::AllOf(testing::HasSubstr("\"light_fields\""), testing::HasSubstr(one),
                                          testing::HasSubstr("\"mean_edge_deg\""),
                                          testing::HasSubstr("\"angular_range_deg\"")));
  EXPECT_THAT(test::RunUlf("info " + one + " " + two + " --cap 10x10").output,
              testing::HasSubstr("covered, % of the cap"));
  // What cannot be read costs its own row alone.
  const auto broken = test::RunUlf("info " + one + " " + none + " " + two);
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_THAT(broken.errors, testing::HasSubstr(none));
  EXPECT_THAT(broken.output, testing::AllOf(testing::HasSubstr(one), testing::HasSubstr(two)));
  EXPECT_EQ(test::RunUlf("info " + one + " " + two + " --check-poses").exit_code, 2);
}

// Files are no camera in the hand: what the command says is for whoever has the files.
TEST(FewViews, AFolderOfFilesIsNotToldToMove) {
  test::ScratchFolder scratch;
  const auto folder = scratch / "files";
  std::filesystem::create_directories(folder);
  cv::Mat picture(240, 320, CV_8UC3);
  cv::RNG random(5);
  random.fill(picture, cv::RNG::UNIFORM, 40, 200);
  for (int i = 0; i < 5; ++i) cv::imwrite((folder / ("p" + std::to_string(i) + ".png")).string(), picture);
  const auto capture = test::RunUlf("capture replay:" + folder.string() + " -o " + (scratch / "lf").string() +
                                    " --headless --focal-px 300");
  EXPECT_EQ(capture.exit_code, 1);
  EXPECT_THAT(capture.errors, testing::HasSubstr("ulf import"));
  for (const char* advice :
       {"sideways", "slowly", "hold", "aim", "ulf features", "ulf calibrate", "nearer", "wait"})
    EXPECT_THAT(capture.errors, testing::Not(testing::HasSubstr(advice))) << advice;
}

}  // namespace
}  // namespace ulf::few_views_test
