// Tests: commands/light_field/export_depths, commands/light_field/export_command,
// core/light_field/exchange/exported_photographs, core/light_field/exchange/export_light_field.
//
// `ulf export FORM --depth`: what nerfstudio and instant-ngp read of a drawn scene lies where the scene is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/image/files/exr_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/mesh_file.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::export_depth_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using nlohmann::json;
using testing::HasSubstr;

class ExportDepth : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch_ = new test::ScratchFolder;
    test::WriteLightField(
        Dir(), {.viewpoints = test::CapViewpoints(6, 0.5, 2.0), .distortion = Distortion::kRadialTangential},
        true);
    fs::copy(Dir(), *scratch_ / "without", fs::copy_options::recursive);
    const LightField light_field = ReadLightField(Dir());
    const auto mesh = test::PlaneAndSquare();
    std::map<int, render::ViewDepthMap> maps;
    for (const View& view : light_field.views)
      maps.emplace(view.id, render::DepthMapOfMesh(
                                *mesh, light_field.CameraOf(view).WithoutDistortion().ScaledTo(48, 36),
                                view.cam_from_world, 0.005));
    render::WriteGeometryFiles(light_field, render::MeshPlyBytes(*mesh), maps,
                               render::FormerGeometry::kReplaced);
    // The first two views have masks, and so every view of the export.
    cv::Mat mask(light_field.cameras[0].height, light_field.cameras[0].width, CV_8U, cv::Scalar(255));
    mask(cv::Rect(0, 0, 30, mask.rows)) = 0;
    LightFieldWriter writer = LightFieldWriter::Resume(Dir());
    writer.SetMasks({{light_field.views[0].id, mask}, {light_field.views[1].id, mask}});
    writer.Close(1);
  }
  static void TearDownTestSuite() { delete scratch_; }
  static fs::path Dir() { return *scratch_ / "lf"; }
  static json Export(const std::string& form, const fs::path& out) {
    const std::string points = form == "instant-ngp" ? " " : " --known-points ";
    const auto run = test::RunUlf("export " + form + " --depth" + points + Dir().string() + " -o " +
                                  out.string() + " --json");
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return JsonOrDiscarded(run.output);
  }
  static test::ScratchFolder* scratch_;
};
test::ScratchFolder* ExportDepth::scratch_ = nullptr;

// A frame of transforms.json with its depth map, read by the rules of nerfstudio's DepthDataset.
struct ReadFrame {
  CameraModel camera;
  Eigen::Matrix4d world_from_gl = Eigen::Matrix4d::Identity();
  cv::Mat depth;  // CV_32F, world units
};

ReadFrame FrameOf(const fs::path& folder, const LightField& read, const json& document, std::size_t i,
                  const char* path_key, const char* unit_key) {
  ReadFrame frame;
  const json& of_frame = document["frames"][i];
  frame.camera = read.CameraOf(read.views[i]);
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      frame.world_from_gl(r, c) =
          of_frame["transform_matrix"][static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
  const cv::Mat stored =
      cv::imread((folder / of_frame[path_key].get<std::string>()).string(), cv::IMREAD_ANYDEPTH);
  EXPECT_EQ(stored.type(), CV_16UC1);
  stored.convertTo(frame.depth, CV_32F, document[unit_key].get<double>());
  return frame;
}

// Along the axis, to the square or else to the plane z = 0, by the pose in the file.
double TrueDepth(const ReadFrame& frame, int x, int y) {
  const Vector3d ray_in_cam = *frame.camera.RayFromImg({x + 0.5, y + 0.5});
  const Vector3d center = frame.world_from_gl.topRightCorner<3, 1>(),
                 ray = frame.world_from_gl.topLeftCorner<3, 3>() *
                       Vector3d(ray_in_cam.x(), -ray_in_cam.y(), -ray_in_cam.z());
  const double to_square = (test::kSquareZ - center.z()) / ray.z();
  const Vector3d on_square = center + to_square * ray;
  const bool hits = std::max(std::abs(on_square.x()), std::abs(on_square.y())) < test::kSquareHalf;
  return (hits ? to_square : -center.z() / ray.z()) * ray_in_cam.z();
}

struct Agreement {
  double known = 0, wrong = 0;  // shares of the pixels
};
Agreement WithTruth(const ReadFrame& frame) {
  Agreement agreement;
  const double pixel = 1 / static_cast<double>(frame.depth.total());
  for (int y = 0; y < frame.depth.rows; ++y)
    for (int x = 0; x < frame.depth.cols; ++x) {
      const float depth = frame.depth.at<float>(y, x);
      if (depth <= 0) continue;
      const double truth = TrueDepth(frame, x, y);
      agreement.known += pixel;
      agreement.wrong += std::abs(depth - truth) > 0.005 * truth ? pixel : 0;
    }
  return agreement;
}

TEST_F(ExportDepth, PngLiesOnTheSceneForNerfstudio) {
  for (const char* undistort : {"", " --undistort"}) {
    const fs::path out = *scratch_ / fmt::format("nerfstudio{}", std::strlen(undistort));
    const json report = Export(std::string("nerfstudio") + undistort, out);
    EXPECT_EQ(report["depths"]["maps"], 6);
    EXPECT_EQ(report["depths"]["units"], "arbitrary");
    const json document = JsonOrDiscarded(ReadWholeFile(out / "transforms.json"));
    EXPECT_EQ(document["depth_unit_scale_factor"], report["depths"]["png_unit"]);
    const LightField read = ReadLightField(out);
    for (std::size_t i = 0; i < read.views.size(); ++i) {
      const ReadFrame frame = FrameOf(out, read, document, i, "depth_file_path", "depth_unit_scale_factor");
      EXPECT_EQ(frame.depth.size(), cv::imread((out / read.views[i].image_path).string()).size());
      const Agreement agreement = WithTruth(frame);
      EXPECT_GT(agreement.known, i < 2 ? 0.55 : 0.95) << i << undistort;
      EXPECT_LT(agreement.wrong, 0.04) << i << undistort << ", beside the square's edges";
    }
  }
}

TEST_F(ExportDepth, ExrHoldsTheSameWithConfidence) {
  const fs::path out = *scratch_ / "colmap";
  const json report = Export("colmap", out);
  const LightField source = ReadLightField(Dir());
  for (std::size_t i = 0; i < source.views.size(); ++i) {
    const std::string stem = (out / "depths" / fs::path(source.views[i].image_path).stem()).string();
    const cv::Mat z = ReadExrChannel(stem + ".exr", "Z"),
                  confidence = ReadExrChannel(stem + ".exr", "confidence");
    const cv::Mat png = cv::imread(stem + ".png", cv::IMREAD_ANYDEPTH);
    ASSERT_EQ(z.size(), png.size());
    ASSERT_EQ(confidence.size(), png.size());
    EXPECT_GT(cv::mean(confidence, png > 0)[0], 0.8);
    for (int y = 0; y < z.rows; ++y)
      for (int x = 0; x < z.cols; ++x) {
        const bool is_known = png.at<std::uint16_t>(y, x) > 0;
        ASSERT_EQ(std::isnan(z.at<float>(y, x)), !is_known) << "unknown is NaN in one and 0 in the other";
        if (is_known) {
          ASSERT_NEAR(z.at<float>(y, x),
                      report["depths"]["png_unit"].get<double>() * png.at<std::uint16_t>(y, x),
                      0.51 * report["depths"]["png_unit"].get<double>());
        }
        if (i < 2 && x < 30) {
          ASSERT_FALSE(is_known) << "masked";
        }
      }
  }
}

TEST_F(ExportDepth, InstantNgpHasItsOwnKeys) {
  const fs::path out = *scratch_ / "ngp";
  Export("instant-ngp", out);
  const json document = JsonOrDiscarded(ReadWholeFile(out / "transforms.json"));
  const LightField read = ReadLightField(out);
  const ReadFrame frame = FrameOf(out, read, document, 3, "depth_path", "integer_depth_scale");
  EXPECT_GT(WithTruth(frame).known, 0.9);
  EXPECT_LT(WithTruth(frame).wrong, 0.04);
  EXPECT_FALSE(document.contains("depth_unit_scale_factor"));
}

TEST_F(ExportDepth, SaysWhatItNeedsAndHowItIsRead) {
  const auto without = test::RunUlf("export nerfstudio --depth " + (*scratch_ / "without").string() + " -o " +
                                    (*scratch_ / "none").string());
  EXPECT_EQ(without.exit_code, 1);
  EXPECT_THAT(without.errors, HasSubstr("ulf proxy"));
  EXPECT_FALSE(fs::exists(*scratch_ / "none"));
  const auto told = test::RunUlf("export colmap --depth --known-points " + Dir().string() + " -o " +
                                 (*scratch_ / "told").string());
  EXPECT_THAT(told.output, testing::AllOf(HasSubstr("depths: 6 maps, along the optical axis, known in"),
                                          HasSubstr("EXR in the light field's own unit"),
                                          HasSubstr("--depths-path depths")));
  EXPECT_EQ(test::RunUlf("export realityscan --depth " + Dir().string() + " -o " + (*scratch_ / "r").string())
                .exit_code,
            2);
}

}  // namespace
}  // namespace ulf::export_depth_test
