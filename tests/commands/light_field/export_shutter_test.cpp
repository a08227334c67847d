// Tests: commands/light_field/export_shutter, core/light_field/exchange/exported_photographs,
// core/light_field/exchange/export_light_field, core/light_field/formats/transforms_json.
//
// `ulf export` of photographs that a rolling shutter took of a drawn wall.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/core/light_field/reader_rules.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/rolling_light_field.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::export_shutter_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

constexpr double kReadout_s = 0.03;

class ExportShutter : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch_ = new test::ScratchFolder;
    rolling_ = new test::RollingLightField(test::MakeRollingLightField(
        CameraModel::Pinhole(320, 240, 260), kReadout_s, 0.6, 0.4, *scratch_ / "lf"));
  }
  static void TearDownTestSuite() {
    delete scratch_;
    delete rolling_;
  }
  static test::CommandResult Export(const std::string& arguments, const std::string& out) {
    const std::string points = arguments.starts_with("instant-ngp") ? " " : " --known-points ";
    return test::RunUlf("export " + arguments + points + (*scratch_ / "lf").string() + " -o " +
                        (*scratch_ / out).string());
  }
  static Rigid3 Truth(std::size_t view, double time_s) {
    return tracking::Perturbed(rolling_->middle_rows[view], time_s * rolling_->twists[view]);
  }
  static test::ScratchFolder* scratch_;
  static test::RollingLightField* rolling_;
};
test::ScratchFolder* ExportShutter::scratch_ = nullptr;
test::RollingLightField* ExportShutter::rolling_ = nullptr;

// By the rule of transforms.json: camera to world with OpenGL's axes.
Rigid3 PoseOf(const json& rows) {
  Eigen::Matrix4d world_from_gl;
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t c = 0; c < 4; ++c)
      world_from_gl(static_cast<int>(r), static_cast<int>(c)) = rows[r][c].get<double>();
  return Rigid3::FromMatrix(world_from_gl * Eigen::Vector4d(1, -1, -1, 1).asDiagonal()).Inverse();
}

double ApartPx(const Rigid3& a, const Rigid3& b) {
  const CameraModel camera = CameraModel::Pinhole(320, 240, 260);
  double most = 0;
  for (const double x : {-0.8, 0.8})
    for (const double y : {-0.6, 0.6}) {
      const Eigen::Vector3d point(x, y, test::kWallDistance);
      most = std::max(most, (*camera.ImgFromCam(a * point) - *camera.ImgFromCam(b * point)).norm());
    }
  return most;
}

TEST_F(ExportShutter, EdgesHaveTheirPoses) {
  for (const char* form : {"nerfstudio", "instant-ngp"}) {
    const auto run = Export(form, form);
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.output, HasSubstr("rolling shutter of 30.0 ms: 8 of 8 views have the poses"));
    const json document = JsonOrDiscarded(ReadWholeFile(*scratch_ / form / "transforms.json"));
    EXPECT_EQ(document["rolling_shutter"], json({0, 0, 1}));
    for (std::size_t v = 0; v < rolling_->middle_rows.size(); ++v) {
      const json& frame = document["frames"][v];
      EXPECT_LT(ApartPx(PoseOf(frame["transform_matrix_start"]), Truth(v, -kReadout_s / 2)), 0.2);
      EXPECT_LT(ApartPx(PoseOf(frame["transform_matrix_end"]), Truth(v, kReadout_s / 2)), 0.2);
      EXPECT_GT(ApartPx(PoseOf(frame["transform_matrix_start"]), PoseOf(frame["transform_matrix_end"])), 2);
    }
  }
}

// Our own reader keeps the picture's pose, without a doubt.
TEST_F(ExportShutter, EdgePosesComeBackAsTheyWere) {
  ASSERT_EQ(Export("nerfstudio", "again").exit_code, 0);
  const LightField read = ReadLightField(*scratch_ / "again");
  for (std::size_t v = 0; v < read.views.size(); ++v) {
    EXPECT_LT(ApartPx(read.views[v].cam_from_world, rolling_->light_field.views[v].cam_from_world), 1e-6);
    EXPECT_EQ(read.views[v].twist, rolling_->light_field.views[v].twist);
  }
  for (const std::string& doubt : read.doubts) EXPECT_THAT(doubt, testing::Not(HasSubstr("moved meanwhile")));
}

double Psnr(const cv::Mat& a, const cv::Mat& b, const cv::Mat& valid) {
  const double error = cv::norm(a, b, cv::NORM_L2, valid);
  return 10 * std::log10(255.0 * 255.0 * cv::countNonZero(valid) / (error * error));
}

TEST_F(ExportShutter, GlobalShutterIsAPictureOfOneInstant) {
  const auto run = Export("colmap --global-shutter", "global");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("8 of 8 views drawn as of one instant"));
  const test::ColmapRead model = test::ReadAsColmap(*scratch_ / "global/sparse/0");
  const test::TexturedRoom wall = test::PlainWall();
  const CameraModel camera = CameraModel::Pinhole(320, 240, 260);
  std::size_t masked = 0;
  for (std::size_t v = 0; v < rolling_->middle_rows.size(); ++v) {
    const View& view = rolling_->light_field.views[v];
    const std::string name = fs::path(view.image_path).filename();
    const auto& image = test::ImageNamed(model, name);
    const Rigid3 pose{image.rotation, image.translation};
    EXPECT_LT(ApartPx(pose, rolling_->middle_rows[v]), 0.2);
    const cv::Mat drawn = cv::imread((*scratch_ / "global/images" / name).string(), cv::IMREAD_GRAYSCALE),
                  taken = cv::imread((*scratch_ / "lf" / view.image_path).string(), cv::IMREAD_GRAYSCALE),
                  mask = cv::imread((*scratch_ / "global/masks" / (name + ".png")).string(),
                                    cv::IMREAD_GRAYSCALE);
    const cv::Mat before = wall.Take(view.cam_from_world, 0, camera).image.pixels,
                  truth = wall.Take(pose, 0, camera).image.pixels;
    EXPECT_GT(cv::countNonZero(mask), 0.9 * static_cast<double>(mask.total()));
    masked += mask.total() - static_cast<std::size_t>(cv::countNonZero(mask));
    EXPECT_GT(Psnr(drawn, truth, mask), Psnr(taken, before, mask) + 5) << name;
    for (std::size_t i = 0; i < image.places.size(); ++i)
      if (image.point_ids[i] >= 0) {
        const auto expected = camera.ImgFromCam(pose * model.points.at(image.point_ids[i]).position);
        EXPECT_LT((*expected - image.places[i]).norm(), 0.2);
      }
  }
  EXPECT_GT(masked, 0u) << "what no row saw";
}

TEST_F(ExportShutter, WithoutAReadoutThereIsNothingToUndo) {
  LightField still = ReadLightField(*scratch_ / "lf");
  const fs::path dir = *scratch_ / "still";
  fs::copy(*scratch_ / "lf", dir, fs::copy_options::recursive);
  still.root = dir;
  const auto run_with = [&](std::optional<ShutterReadout> readout, const char* out) {
    still.readout = readout;
    WriteLightField(still);
    return test::RunUlf("export nerfstudio --known-points --global-shutter " + dir.string() + " -o " +
                        (*scratch_ / out).string());
  };
  const auto unknown = run_with(std::nullopt, "unknown");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, HasSubstr("--readout-ms"));
  const auto global = run_with(ShutterReadout{0, {}}, "none");
  EXPECT_EQ(global.exit_code, 0);
  EXPECT_THAT(global.output,
              testing::AllOf(HasSubstr("shutter is global"), HasSubstr("all copied as they are")));
}

}  // namespace
}  // namespace ulf::export_shutter_test
