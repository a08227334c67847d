// Tests: commands/rendering/against, commands/rendering/protocol_evaluation,
// commands/rendering/protocol_result, commands/rendering/refined_split.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/quality/quality.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::protocol_command_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using nlohmann::json;
using test::RunUlf;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kViews = 20;

// A wall with a board before it, drawn once in every size: `times` as large in pixels.
const std::vector<test::Drawn>& DrawnViews(int times) {
  static std::map<int, std::vector<test::Drawn>> of_size;
  std::vector<test::Drawn>& views = of_size[times];
  if (!views.empty()) return views;
  const test::Patch wall{{-8, -6, 3}, {16, 0, 0}, {0, 12, 0}, test::Mottled(0.02, 1)},
      board{{-0.4, -0.3, 2.2}, {0.8, 0, 0}, {0, 0.6, 0}, test::Mottled(0.1, 2)};
  for (const Vector3d& place : test::GridViewpoints(5, 4, 0.2, 0.0))
    views.push_back(test::Draw({wall, board}, place, {0, 0, 3}, 120 * times, 90 * times, 110.0 * times));
  return views;
}

// As another program posed its photographs, with points on both. `turned_deg`: by what the set's
// poses are off.
void WriteSet(const fs::path& dir, bool spoil_test_photographs, int times = 1, double turned_deg = 0) {
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(120 * times, 90 * times, 110.0 * times);
  header.device_uri = "import:wall";
  auto writer = LightFieldWriter::Create(dir, header);
  std::vector<View> views;
  for (const test::Drawn& drawn : DrawnViews(times)) {
    cv::Mat grey, colour;
    drawn.view.grey.convertTo(grey, CV_8U);
    cv::merge(std::vector<cv::Mat>(3, grey), colour);
    if (spoil_test_photographs && views.size() % 8 == 0) cv::RNG(9).fill(colour, cv::RNG::UNIFORM, 0, 256);
    Frame frame;
    frame.image = {.pixels = colour, .transfer = Transfer::kSrgb};
    View view;
    view.cam_from_world = drawn.view.cam_from_world;
    if (turned_deg > 0) {  // about an axis that differs from view to view
      const double at = 2.4 * static_cast<double>(views.size());
      const Eigen::Quaterniond turn(
          Eigen::AngleAxisd(turned_deg * M_PI / 180, Vector3d(std::cos(at), std::sin(at), 0)));
      view.cam_from_world = Rigid3{turn, Vector3d::Zero()} * view.cam_from_world;
    }
    views.push_back(writer.AddView(frame, view));
  }
  std::vector<ScenePoint> points;
  cv::RNG random(3);
  for (int i = 0; i < 300; ++i) {
    ScenePoint point;
    point.position_in_world = i % 3 == 0 ? Vector3d(random.uniform(-0.4, 0.4), random.uniform(-0.3, 0.3), 2.2)
                                         : Vector3d(random.uniform(-2.0, 2.0), random.uniform(-1.5, 1.5), 3);
    for (const View& view : views) {
      const auto img = header.camera.ImgFromCam(view.cam_from_world * point.position_in_world);
      if (!img || !header.camera.Contains(*img)) continue;
      const bool is_spoiled = spoil_test_photographs && (view.id - 1) % 8 == 0;
      point.track.push_back({view.id, is_spoiled ? Vector3d(5, 5, 0).head<2>() : *img});
    }
    if (point.track.size() > 1) points.push_back(point);
  }
  writer.SetPoints(points);
  writer.SetSubject({spoil_test_photographs ? Vector3d(0.5, 0.4, 2) : Vector3d(0, 0, 3), 0.8});
  writer.Close(1.0);
}

class ProtocolCommand : public testing::Test {
 protected:
  json Run(const fs::path& dir, const std::string& more) {
    const auto run = RunUlf("evaluate " + dir.string() + " --json " + more);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return JsonFromText(run.output);
  }
  test::ScratchFolder scratch_;
  fs::path dir_ = scratch_ / "set";
};

// What the whole protocol is for: other photographs in the test views' places change the scores
// and nothing else.
TEST_F(ProtocolCommand, NothingIsMadeFromTheTestViews) {
  WriteSet(dir_, false);
  WriteSet(scratch_ / "spoiled", true);
  const std::string protocol = "--protocol llff -o ";
  const json whole = Run(dir_, protocol + (scratch_ / "a").string());
  const json spoiled = Run(scratch_ / "spoiled", protocol + (scratch_ / "b").string());
  EXPECT_EQ(ReadWholeFile(scratch_ / "a/proxy.ply"), ReadWholeFile(scratch_ / "b/proxy.ply"));
  for (const char* made : {"chosen_by", "field", "proxy"}) EXPECT_EQ(whole[made], spoiled[made]) << made;
  for (const char* name : {"000001.png", "000009.png", "000017.png"})
    EXPECT_EQ(ReadWholeFile(scratch_ / "a/rendered" / name), ReadWholeFile(scratch_ / "b/rendered" / name))
        << name;
  EXPECT_GT(whole["mean"]["psnr_db"], 20);
  EXPECT_LT(spoiled["mean"]["psnr_db"], 12);
  EXPECT_THAT(whole["chosen_by"].get<std::string>(),
              AllOf(HasSubstr("plane"), HasSubstr("points"), HasSubstr("soft")));
  std::vector<std::string> questions;
  for (const json& choice : whole["explain"]) questions.push_back(choice["question"]);
  EXPECT_THAT(questions, testing::IsSupersetOf({"proxy", "blending field"}));
}

// Poses that are off are mended, and still nothing is made from the test views but their own places.
TEST_F(ProtocolCommand, RefinesGivenViewsAndPlacesTheRest) {
  constexpr int kTimes = 2;
  constexpr double kTurnedDeg = 0.4;
  WriteSet(dir_, false, kTimes, kTurnedDeg);
  WriteSet(scratch_ / "spoiled", true, kTimes, kTurnedDeg);
  const std::string protocol = "--protocol llff --proxy mesh --fields lumigraph --geometry-size 180 ";
  const json as_said = Run(dir_, protocol),
             refined = Run(dir_, protocol + "--refine -o " + (scratch_ / "a").string());
  EXPECT_EQ(as_said["refined"], "");
  EXPECT_THAT(refined["refined"].get<std::string>(), HasSubstr("before"));
  EXPECT_GT(refined["mean"]["psnr_db"].get<double>(), as_said["mean"]["psnr_db"].get<double>() + 3);
  Run(scratch_ / "spoiled", protocol + "--refine -o " + (scratch_ / "b").string());
  EXPECT_EQ(ReadWholeFile(scratch_ / "a/proxy.ply"), ReadWholeFile(scratch_ / "b/proxy.ply"));
}

TEST_F(ProtocolCommand, SaysWhereTheErrorIs) {
  WriteSet(dir_, false);
  const json result = Run(dir_, "--protocol llff --proxy mesh --fields soft");
  double of_error = 0, of_pixels = 0;
  for (const char* kind : {"unseen", "thin parts", "depth edges", "blurred", "displaced", "light", "other"}) {
    of_error += result["errors"][kind]["of_error"].get<double>();
    of_pixels += result["errors"][kind]["of_pixels"].get<double>();
  }
  EXPECT_NEAR(of_error, 1, 1e-9);
  EXPECT_NEAR(of_pixels, 1, 1e-9);
  WriteSet(scratch_ / "spoiled", true);
  const json noise = Run(scratch_ / "spoiled", "--protocol llff --proxy soft --fields soft");
  double explained = 0;
  for (const char* kind : {"blurred", "displaced", "light"})
    explained += noise["errors"][kind]["of_error"].get<double>();
  EXPECT_GT(explained, 0.3) << "noise that is blended is a blurred photograph";
}

TEST_F(ProtocolCommand, GeometryIsOfAsManyMapsAsAskedFor) {
  WriteSet(dir_, false);
  const std::string protocol = "--protocol every:10 --proxy soft --fields soft ";
  const json all = Run(dir_, protocol), few = Run(dir_, protocol + "--geometry-maps 5");
  EXPECT_EQ(all["depth_maps"], kViews - 2);
  EXPECT_EQ(few["depth_maps"], 5);
  EXPECT_NE(few["mean"]["psnr_db"], all["mean"]["psnr_db"]);
  EXPECT_EQ(RunUlf("evaluate " + dir_.string() + " --every 5 --geometry-maps 5").exit_code, 2);
}

TEST_F(ProtocolCommand, WritesPicturesATableAndJson) {
  WriteSet(dir_, false);
  const json result =
      Run(dir_, "--protocol every:10 --proxy plane --fields lumigraph -o " + (scratch_ / "out").string());
  EXPECT_EQ(result["test"], 2);
  EXPECT_EQ(result["given"], kViews - 2);
  EXPECT_EQ(result["width_px"], 120);
  EXPECT_THAT(result["proxy"].get<std::string>(), testing::StartsWith("plane"));
  EXPECT_EQ(result["views"][1]["name"], "000011.png");
  EXPECT_TRUE(result["lpips"].is_null());
  EXPECT_EQ(JsonFromText(ReadWholeFile(scratch_ / "out/result.json"))["mean"], result["mean"]);
  EXPECT_THAT(ReadWholeFile(scratch_ / "out/result.txt"),
              AllOf(HasSubstr("000011.png"), HasSubstr("SSIM uniform")));
  const cv::Mat rendered = cv::imread((scratch_ / "out/rendered/000011.png").string()),
                photograph = cv::imread((scratch_ / "out/photographs/000011.png").string());
  EXPECT_EQ(rendered.size(), cv::Size(120, 90));
  EXPECT_NEAR(CompareImages(rendered, photograph, cv::Mat(rendered.size(), CV_8U, cv::Scalar(1))).psnr_db,
              result["views"][1]["psnr_db"], 1e-9);
  EXPECT_EQ(cv::norm(photograph, ReadImageFile((dir_ / "images/000011.png").string()), cv::NORM_INF), 0);
  EXPECT_FALSE(fs::exists(scratch_ / "out/proxy.ply")) << "none was asked for";
}

// The same photographs, posed rightly and wrongly: both render the same ones, and the right poses win.
TEST_F(ProtocolCommand, ComparesTwoLightFields) {
  WriteSet(dir_, false);
  WriteSet(scratch_ / "off", false, 1, 1.5);
  const std::string against =
      "--against " + (scratch_ / "off").string() + " --every 10 --proxy plane --fields lumigraph ";
  const json both =
      Run(dir_, against + "-o " + (scratch_ / "out").string() + " --table " + (scratch_ / "t.csv").string());
  EXPECT_EQ(both["shared"], kViews);
  EXPECT_EQ(both["left_out"], 2);
  ASSERT_EQ(both["views"].size(), 2u);
  // Each side is what the protocol alone makes of it.
  const json alone = Run(scratch_ / "off", "--protocol every:10 --proxy plane --fields lumigraph ");
  for (int i = 0; i < 2; ++i) {
    const json& view = both["views"][i];
    EXPECT_EQ(view["name"], i == 0 ? "000001.png" : "000011.png");
    EXPECT_EQ(view["name_in_b"], view["name"]);
    EXPECT_GT(view["psnr_a_db"].get<double>(), view["psnr_b_db"].get<double>() + 1);
    EXPECT_EQ(view["psnr_b_db"], alone["views"][i]["psnr_db"]);
  }
  const json &first = both["views"][0], &second = both["views"][1], &difference = both["difference"];
  const double one = first["psnr_a_db"].get<double>() - first["psnr_b_db"].get<double>(),
               other = second["psnr_a_db"].get<double>() - second["psnr_b_db"].get<double>();
  EXPECT_EQ(difference["better"], 2);
  EXPECT_NEAR(difference["psnr_db"], 0.5 * (one + other), 1e-9);
  EXPECT_NEAR(difference["psnr_standard_error_db"], 0.5 * std::abs(one - other), 1e-9) << "of two";
  for (const char* file : {"A/rendered/000011.png", "B/rendered/000011.png", "B/photographs/000001.png",
                           "result.json", "result.txt"})
    EXPECT_TRUE(fs::exists(scratch_ / "out" / file)) << file;
  EXPECT_THAT(ReadWholeFile(scratch_ / "t.csv"), HasSubstr("\n\"000011.png\",\"000011.png\","));
  EXPECT_THAT(ReadWholeFile(scratch_ / "out/result.txt"),
              AllOf(HasSubstr("20 photographs in both, 2 left out"), HasSubstr("A is better in 2 of 2")));
}

// Pixels that one of them masks count for neither.
TEST_F(ProtocolCommand, ComparesOnlyWhatBothShow) {
  WriteSet(dir_, false);
  WriteSet(scratch_ / "masked", false);
  {
    auto writer = LightFieldWriter::Resume(scratch_ / "masked");
    std::map<int, cv::Mat> masks;
    for (const View& view : writer.Contents().views) {
      masks[view.id] = cv::Mat(90, 120, CV_8U, cv::Scalar(255));
      masks[view.id](cv::Rect(0, 0, 120, 30)) = 0;
    }
    writer.SetMasks(masks);
    writer.Close(1.0);
  }
  const json both = Run(
      dir_, "--against " + (scratch_ / "masked").string() + " --every 10 --proxy plane --fields lumigraph");
  for (const char* side : {"a", "b"})
    for (const json& view : both[side]["views"]) EXPECT_EQ(view["masked_px"], 120 * 30) << side;
}

TEST_F(ProtocolCommand, RefusesToCompareOthers) {
  WriteSet(dir_, false);
  fs::copy(dir_, scratch_ / "noise", fs::copy_options::recursive);
  for (const auto& photograph : fs::directory_iterator(scratch_ / "noise/images")) {
    cv::Mat noise(90, 120, CV_8UC3);
    cv::RNG(fs::file_size(photograph)).fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::imwrite(photograph.path().string(), noise);
  }
  const std::string evaluate = "evaluate " + dir_.string() + " --against ";
  const auto other = RunUlf(evaluate + (scratch_ / "noise").string());
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.errors, AllOf(HasSubstr("no photograph in common"), HasSubstr("20 photographs")));
  const auto used = RunUlf(evaluate + (scratch_ / "noise").string() + " -o " + dir_.string());
  EXPECT_EQ(used.exit_code, 1);
  EXPECT_THAT(used.errors, HasSubstr("exists already")) << "before photographs are compared";
  const auto refined = RunUlf(evaluate + dir_.string() + " --refine");
  EXPECT_EQ(refined.exit_code, 2);
  EXPECT_THAT(refined.errors, HasSubstr("ulf refine"));
  EXPECT_EQ(RunUlf("evaluate " + dir_.string() + " --every 5 -o " + (scratch_ / "no").string()).exit_code, 2);
  EXPECT_EQ(RunUlf("evaluate " + dir_.string() + " --protocol llff --table t.csv").exit_code, 2);
}

TEST_F(ProtocolCommand, RefusesWhatWouldLeak) {
  WriteSet(dir_, false);
  const std::string evaluate = "evaluate " + dir_.string() + " --protocol llff";
  const auto mesh = RunUlf(evaluate + " --proxy some.ply");
  EXPECT_EQ(mesh.exit_code, 2);
  EXPECT_THAT(mesh.errors, HasSubstr("given photographs alone"));
  const auto other = RunUlf("evaluate " + dir_.string() + " --protocol nerf");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.errors, HasSubstr("llff, nerf-synthetic"));
  const auto every = RunUlf(evaluate + " --every 4");
  EXPECT_EQ(every.exit_code, 2);
  EXPECT_THAT(every.errors, HasSubstr("every:4"));
  fs::create_directories(scratch_ / "full");
  WriteFileAtomically(scratch_ / "full/mine", "mine");
  EXPECT_EQ(RunUlf(evaluate + " -o " + (scratch_ / "full").string()).exit_code, 1);
  EXPECT_EQ(ReadWholeFile(scratch_ / "full/mine"), "mine");
}

}  // namespace
}  // namespace ulf::protocol_command_test
