// Tests: commands/rendering/mask_command, commands/capture/capture_command, render/renderer/cut_out_renderer,
// commands/options/option_values, acquisition/simulator/tripod.
//
// A capture whose subject turns before a camera that stands, from the first frame to a picture without
// the background.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "acquisition/simulator/simulated_camera.h"
#include "acquisition/simulator/tripod.h"
#include "core/base/json_text.h"
#include "core/base/quantile.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/render/masks/turntable_scene.h"
#include "tests/support/floors.h"
#include "tests/support/pose_readers.h"
#include "tests/support/test_paths.h"

namespace ulf::turntable_capture_test {
namespace {

using test::RunUlf;
using ::testing::HasSubstr;

constexpr const char* kBoard = "charuco:5x5:54:40:DICT_4X4_50";

TEST(TurntableCapture, CapturesWithoutTheBackground) {
  test::ScratchFolder scratch;
  const std::string dir = (scratch / "field").string(), uri = "sim:turntable?cap=60x10&row_deg=12&fps=3";
  const auto captured = RunUlf(
      fmt::format("capture '{}' -o {} --headless --deterministic --no-geometry --turntable {} --quality fast "
                  "--max-seconds 15 --json",
                  uri, dir, kBoard));
  ASSERT_EQ(captured.exit_code, 0) << captured.errors;
  EXPECT_THAT(captured.errors, HasSubstr("masked"));
  EXPECT_TRUE(JsonFromText(captured.output)["mistakes"].empty())
      << "what stands still is no dust: " << captured.output;
  const LightField light_field = ReadLightField(dir);
  EXPECT_EQ(light_field.units, "metres");
  ASSERT_TRUE(light_field.turntable);
  EXPECT_EQ(light_field.turntable->board, kBoard);
  ASSERT_GE(light_field.views.size(), 20u);

  // Poses are the camera's about what turns, in the board's frame.
  const SimulatedCamera camera(SimulationOptions::FromUri(DeviceUri::Parse(uri)));
  const StandingBoard& board = *camera.scene().board();
  std::vector<double> errors_m, overlaps;
  for (const View& view : light_field.views) {
    const Rigid3 truth = camera.CamFromRest(view.device_time_s) * board.board_from_world.Inverse();
    errors_m.push_back((view.CenterInWorld() - truth.OriginInSource()).norm());
    overlaps.push_back(
        test::OverlapOf(ReadViewMask(light_field, view), camera.MovingPixels(view.device_time_s)));
  }
  EXPECT_LT(Median(errors_m), 0.003);
  EXPECT_GT(Median(overlaps), 0.97);
  EXPECT_GT(Quantile(overlaps, 0), 0.93);
  // It is found above the board: what stands there is inside its sphere.
  ASSERT_TRUE(light_field.subject);
  const Subject& subject = *light_field.subject;
  const Eigen::Vector3d truth = board.board_from_world * camera.scene().subject().center_in_world;
  EXPECT_LT((subject.center_in_world - truth).norm(), 0.05);

  const auto again = RunUlf(fmt::format("mask {} --truth '{}' --json", dir, uri));
  ASSERT_EQ(again.exit_code, 0) << again.errors;
  const auto report = JsonFromText(again.output);
  EXPECT_GT(report["truth"]["iou_median"], 0.97);
  EXPECT_LT(report["truth"]["centers_mm"], 3);
  EXPECT_GT(report["truth"]["centers_mm"], 1e3 * Quantile(errors_m, 0));
  EXPECT_LT(report["truth"]["directions_deg"], 0.2);
  EXPECT_TRUE(std::filesystem::exists(scratch / "field" / "kept" / "masks" / "000001.png"))
      << "the first masks stay";

  const auto rendered =
      RunUlf(fmt::format("render {0} --path {0} --frames 4:5 --proxy plane --field linear --width 320 "
                         "-o {1}/cut.png",
                         dir, scratch.path().string()));
  ASSERT_EQ(rendered.exit_code, 0) << rendered.errors;
  const cv::Mat cut = cv::imread((scratch / "cut.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(cut.channels(), 4);
  EXPECT_EQ(cut.at<cv::Vec4b>(4, 4)[3], 0) << "the wall is not there";
  EXPECT_EQ(cut.at<cv::Vec4b>(cut.rows / 2, cut.cols / 2)[3], 255) << "the subject is";
  const auto white =
      RunUlf(fmt::format("render {0} --path {0} --frames 4:5 --proxy plane --field linear --width 320 "
                         "--background white -o {1}/white.png",
                         dir, scratch.path().string()));
  ASSERT_EQ(white.exit_code, 0) << white.errors;
  const cv::Mat over = cv::imread((scratch / "white.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(over.channels(), 3);
  EXPECT_EQ(over.at<cv::Vec3b>(4, 4), cv::Vec3b(255, 255, 255));
}

TEST(TurntableCapture, SaysThatNothingTurns) {
  test::ScratchFolder scratch;
  const std::string dir = (scratch / "field").string();
  const auto captured =
      RunUlf(fmt::format("capture 'sim:turntable?cap=60x10&row_deg=12&fps=3&turn_deg_s=0' -o {} --headless "
                         "--deterministic --no-geometry "
                         "--turntable {} --max-seconds 6",
                         dir, kBoard));
  EXPECT_EQ(captured.exit_code, 1);
  EXPECT_THAT(captured.errors, AllOf(HasSubstr("the subject does not turn"), HasSubstr("start the turntable"),
                                     HasSubstr("do not turn about one axis"), HasSubstr("ulf mask")));
  EXPECT_FALSE(ReadLightField(dir).views.empty());
}

// Photographs by others of a plaster temple, which to them turned before black cloth: every eighth is left
// out and rendered from the rest, over geometry that was made without it, with the cloth masked and as it is.
TEST(TurntableCapture, MasksImproveARealTemple) {
  ULF_NEED_TEST_DATA(data, "temple_ring");
  test::ScratchFolder scratch;
  LightField temple = test::MiddleburyLightField(data, "templeR_par.txt");
  std::filesystem::create_directories(scratch / "set" / "images");
  for (View& view : temple.views) {
    const auto name = std::filesystem::path(view.image_path).filename();
    std::filesystem::copy_file(data / name, scratch / "set" / "images" / name);
    view.image_path = "images/" + name.string();
  }
  std::ofstream(scratch / "set" / "transforms.json") << TransformsJsonText(temple);
  double disc_db[2] = {};
  for (const bool masked : {false, true}) {
    const std::string field = (scratch / (masked ? "masked" : "plain")).string();
    std::vector<std::string> commands{"import " + (scratch / "set").string() + " -o " + field};
    if (masked) commands.push_back("mask " + field);
    commands.push_back("proxy " + field + " --leave-out-every 8");
    commands.push_back("evaluate " + field + " --every 8 --proxy mesh --fields soft --json");
    for (const std::string& command : commands) {
      const auto ran = RunUlf(command);
      ASSERT_EQ(ran.exit_code, 0) << command << '\n' << ran.errors;
      if (command.starts_with("evaluate"))
        disc_db[masked] = JsonFromText(ran.output)["results"][0]["all"]["psnr_disc_db"];
    }
  }
  fmt::print("temple_ring, disc: {:.2f} dB, with masks {:.2f} dB\n", disc_db[0], disc_db[1]);
  EXPECT_GT(disc_db[1], disc_db[0] + 0.5);
  EXPECT_GT(disc_db[1], 25);
}

TEST(TurntableCapture, SaysThatTheBoardIsNotSeen) {
  test::ScratchFolder scratch;
  const auto captured =
      RunUlf(fmt::format("capture 'sim:studio?fps=3&look_away=0&width=320&height=240' -o {} --headless "
                         "--deterministic --no-geometry "
                         "--turntable {} --max-seconds 4",
                         (scratch / "field").string(), kBoard));
  EXPECT_EQ(captured.exit_code, 1);
  EXPECT_THAT(captured.errors, AllOf(HasSubstr("the board charuco:5x5:54:40:DICT_4X4_50 is not seen"),
                                     HasSubstr("aim at it from higher up")));
}

TEST(Tripod, StandsForATurnAndIsThenRaised) {
  const Tripod tripod(
      {.first_direction = {0, -1, 0.5}, .cap_elevation = Radians(25), .row_spacing = Radians(12)},
      /*stands_s=*/10, /*unsteady=*/0);
  EXPECT_EQ(tripod.Heights(), 3);
  for (const double t : {0.0, 3.0, 9.99}) {
    EXPECT_NEAR(tripod.Elevation(t), Radians(-12), 1e-12) << t;
    EXPECT_LT((tripod.CamFromWorld(t).translation - tripod.CamFromWorld(0).translation).norm(), 1e-12) << t;
  }
  EXPECT_NEAR(tripod.Elevation(12), 0, 1e-12);
  EXPECT_NEAR(tripod.Elevation(24), Radians(12), 1e-12);
  EXPECT_NEAR(tripod.Elevation(36), 0, 1e-12) << "and down again";
}

}  // namespace
}  // namespace ulf::turntable_capture_test
