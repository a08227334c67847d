// Tests: commands/light_field/export_command, commands/light_field/export_scene,
// core/light_field/exchange/export_light_field, render/output/gltf_file.
//
// What programs of others make of a simulated capture that was exported: COLMAP of its masks, Khronos'
// validator and Blender of glTF, and the loaders that whoever has them puts into a folder (ULF_LOADERS).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/image/undistortion.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::programs_of_others_long_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using nlohmann::json;
using test::RunUlf;
using test::ScratchFolder;

class ProgramsOfOthers : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch_ = new ScratchFolder;
    Ulf("capture 'sim:studio?width=320&height=240&row_deg=8' -o " + Dir().string() +
        " --headless --deterministic --poses known --subject 0,0,0.07,0.162 --quality fast --max-seconds 12");
  }
  static void TearDownTestSuite() { delete scratch_; }
  static fs::path Dir() { return *scratch_ / "lf"; }
  static void Ulf(const std::string& arguments) {
    const auto run = RunUlf(arguments);
    ASSERT_EQ(run.exit_code, 0) << arguments << "\n" << run.errors;
  }
  // What a command prints as JSON; an empty object where it fails.
  static json Printed(const std::string& command) {
    const ScratchFolder scratch;
    const fs::path out = scratch / "out", errors = scratch / "errors";
    const int status = std::system((command + " >" + out.string() + " 2>" + errors.string()).c_str());
    EXPECT_EQ(status, 0) << command << "\n" << ReadWholeFile(errors);
    return status == 0 ? JsonFromText(std::ifstream(out)) : json::object();
  }
  static ScratchFolder* scratch_;
};
ScratchFolder* ProgramsOfOthers::scratch_ = nullptr;

TEST_F(ProgramsOfOthers, ColmapObeysMasks) {
  ASSERT_EQ(std::system("command -v colmap >/dev/null"), 0) << "colmap is not installed: ./run deps";
  const ScratchFolder scratch;
  const fs::path masked = scratch / "masked";
  fs::copy(Dir(), masked, fs::copy_options::recursive);
  {
    LightFieldWriter writer = LightFieldWriter::Resume(masked);
    std::map<int, cv::Mat> masks;
    for (const View& view : writer.Contents().views) {
      const CameraModel& camera = writer.Contents().CameraOf(view);
      cv::Mat mask(camera.height, camera.width, CV_8U, cv::Scalar(255));
      mask(cv::Rect(0, 0, camera.width / 2, camera.height)) = 0;
      masks[view.id] = mask;
    }
    writer.SetMasks(masks);
    writer.Close(1);
  }
  Ulf("export colmap --known-points " + masked.string() + " -o " + (scratch / "out").string());
  std::map<std::string, int> excluded, used;  // features left and right of the masks' edge
  for (const std::string mask : {"", "masks"}) {
    const fs::path database = scratch / ("database" + mask);
    std::string command = "QT_QPA_PLATFORM=offscreen colmap feature_extractor --database_path " +
                          database.string() + " --image_path " + (scratch / "out/images").string() +
                          " --SiftExtraction.use_gpu 0";
    if (!mask.empty()) command += " --ImageReader.mask_path " + (scratch / "out" / mask).string();
    ASSERT_EQ(std::system((command + " >/dev/null 2>&1").c_str()), 0) << command;
    const json features = Printed("/usr/bin/python3 " COLMAP_KEYPOINTS " " + database.string());
    EXPECT_EQ(features.size(), ReadLightField(masked).views.size());
    for (const json& places : features)
      for (const json& place : places) ++(place[0] < 160 ? excluded : used)[mask];
  }
  EXPECT_GT(excluded[""], 1000);
  EXPECT_EQ(excluded["masks"], 0);
  EXPECT_GT(used["masks"], 1000);
}

// Tools of npm, as ./run test --long installs them; failing where they are missing.
TEST_F(ProgramsOfOthers, GltfValidatorFindsNothing) {
  const ScratchFolder scratch;
  Ulf("export gltf --texture 1024 " + Dir().string() + " -o " + (scratch / "out").string());
  const std::string files =
      (scratch / "out/lf.glb").string() + " " + (scratch / "out/lf_vertex_colors.glb").string();
  const json reports = Printed("node " VALIDATE_GLTF " " WEB_TOOLS " " + files);
  EXPECT_EQ(reports.size(), 2u) << "is everything there? ./run web installs it";
  for (const auto& [file, report] : reports.items()) {
    EXPECT_EQ(report["issues"]["numErrors"], 0) << JsonText(report, 1);
    EXPECT_EQ(report["issues"]["numWarnings"], 0) << JsonText(report, 1);
    EXPECT_GT(report["info"]["totalTriangleCount"], 1000) << file;
  }
}

// Debian's, as ./run test --long installs it. Its numbers have 32 bits, its world is turned: what two views
// have to each other stays.
TEST_F(ProgramsOfOthers, BlenderHasTheCamerasWhereTheyWere) {
  ASSERT_EQ(std::system("command -v blender >/dev/null"), 0)
      << "blender is not installed: apt install blender";
  const ScratchFolder scratch;
  Ulf("export gltf " + Dir().string() + " -o " + (scratch / "out").string());
  const fs::path out = scratch / "read.json";
  ASSERT_EQ(
      std::system(("blender --background --factory-startup --python-exit-code 1 --python " CAMERAS_IN_BLENDER
                   " -- " +
                   (scratch / "out/lf.glb").string() + " " + out.string() + " >" +
                   (scratch / "said").string() + " 2>&1")
                      .c_str()),
      0)
      << ReadWholeFile(scratch / "said");
  const json read = JsonFromText(std::ifstream(out));
  EXPECT_GT(read["triangles"], 1000);
  const LightField light_field = ReadLightField(Dir());
  ASSERT_EQ(read["cameras"].size(), light_field.views.size());
  const auto seen_in = [&](const View& view) {
    const json& camera = read["cameras"][fs::path(view.image_path).stem().string()];
    Eigen::Matrix4d world_from_cam;
    for (std::size_t k = 0; k < 16; ++k)
      world_from_cam(static_cast<int>(k / 4), static_cast<int>(k % 4)) =
          camera["world_from_camera"][k / 4][k % 4];
    const CameraModel lens = UndistortionOf(light_field.CameraOf(view), "a camera").to;
    EXPECT_NEAR(camera["angle_y"].get<double>(), 2 * std::atan(0.5 * lens.height / lens.fy), 1e-6);
    return Eigen::Matrix4d((world_from_cam * Eigen::Vector4d(1, -1, -1, 1).asDiagonal()).inverse());
  };
  const View& first = light_field.views.front();
  const Eigen::Matrix4d first_in_blender = seen_in(first);
  for (const View& view : light_field.views)
    EXPECT_LT((seen_in(view) * first_in_blender.inverse() -
               view.cam_from_world.Matrix() * first.cam_from_world.Matrix().inverse())
                  .norm(),
              1e-5)
        << view.image_path;
}

void ExpectOurModel(const json& model, const LightField& light_field) {
  EXPECT_GT(model["points"], 500);
  ASSERT_EQ(model["images"].size(), light_field.views.size());
  for (const auto& [name, image] : model["images"].items()) {
    const auto view = std::ranges::find_if(light_field.views, [&, &stem = name](const View& one) {
      return fs::path(one.image_path).stem() == fs::path(stem).stem();
    });
    ASSERT_NE(view, light_field.views.end()) << name;
    const auto q = image["qvec"].get<std::vector<double>>(), t = image["tvec"].get<std::vector<double>>();
    const Rigid3 cam_from_world{Eigen::Quaterniond(q[0], q[1], q[2], q[3]), Vector3d(t[0], t[1], t[2])};
    EXPECT_LT((cam_from_world.Matrix() - view->cam_from_world.Matrix()).norm(), 1e-9);
    const json& camera = model["cameras"][image["camera"].get<std::string>()];
    const CameraModel lens = UndistortionOf(light_field.CameraOf(*view), name).to;
    EXPECT_EQ(camera["model"], "PINHOLE");
    EXPECT_EQ(camera["width"], lens.width);
    EXPECT_NEAR(camera["params"][0], lens.fx, 1e-6);
  }
}

// That world is moved, turned and scaled: what two views have to each other stays.
void ExpectOurViews(const json& read, const json& train, const LightField& light_field) {
  const auto view_of = [&](const json& frame) -> const View& {
    const std::string stem = fs::path(frame.at("file_path").get<std::string>()).stem().string();
    return *std::ranges::find_if(light_field.views,
                                 [&](const View& view) { return fs::path(view.image_path).stem() == stem; });
  };
  const auto pose_of = [&](std::size_t i) {
    Eigen::Matrix4d world_from_cam;
    for (std::size_t k = 0; k < 16; ++k)
      world_from_cam(static_cast<int>(k / 4), static_cast<int>(k % 4)) = read["poses"][i][k / 4][k % 4];
    return Eigen::Matrix4d(world_from_cam * Eigen::Vector4d(1, -1, -1, 1).asDiagonal());
  };
  const json& frames = train.at("frames");
  ASSERT_EQ(read["splits"][0], frames.size());
  const Eigen::Matrix4d first = pose_of(0);
  const View& ours = view_of(frames[0]);
  double scale = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const Eigen::Matrix4d pose = pose_of(i);
    const View& view = view_of(frames[i]);
    EXPECT_LT((pose.topLeftCorner<3, 3>().transpose() * first.topLeftCorner<3, 3>() -
               view.cam_from_world.RotationMatrix() * ours.cam_from_world.RotationMatrix().transpose())
                  .norm(),
              1e-5);
    const double ratio = (pose.topRightCorner<3, 1>() - first.topRightCorner<3, 1>()).norm() /
                         (view.CenterInWorld() - ours.CenterInWorld()).norm();
    if (i == 1) scale = ratio;
    EXPECT_NEAR(ratio / scale, 1, 1e-3);
  }
}

TEST_F(ProgramsOfOthers, LoadersReadWhatIsExportedForThem) {
  const char* loaders = std::getenv("ULF_LOADERS");
  if (!loaders)
    GTEST_SKIP() << "loaders of others were not run: set ULF_LOADERS to a folder with them (docs/exchange.md "
                    "says which)";
  const ScratchFolder scratch;
  for (const std::string form : {"colmap --undistort", "colmap --undistort --binary", "nerf-synthetic"})
    Ulf("export " + form + " " + Dir().string() + " -o " + (scratch / form).string().insert(0, "'") + "'");
  const json read = Printed(std::string("/usr/bin/python3 " LOADERS_OF_OTHERS " ") + loaders + " '" +
                            (scratch / "colmap --undistort").string() + "' '" +
                            (scratch / "colmap --undistort --binary").string() + "' " +
                            (scratch / "nerf-synthetic").string());
  ASSERT_FALSE(read.empty()) << loaders << " has none of the loaders that docs/exchange.md names";
  const LightField light_field = ReadLightField(Dir());
  for (const auto& [loader, what] : read.items()) {
    SCOPED_TRACE(loader);
    std::printf("read by %s\n", loader.c_str());
    if (loader != "load_blender.py") {
      ExpectOurModel(what, light_field);
      continue;
    }
    const CameraModel lens = UndistortionOf(light_field.cameras[0], loader).to;
    EXPECT_EQ(what["height"], lens.height);
    EXPECT_EQ(what["width"], lens.width);
    EXPECT_NEAR(what["focal"], lens.fx, 0.01);
    EXPECT_EQ(what["size"][3], 4) << "red, green, blue, opacity";
    EXPECT_GT(what["most"], 0.8);
    ExpectOurViews(what, JsonFromText(std::ifstream(scratch / "nerf-synthetic/transforms_train.json")),
                   light_field);
  }
}

}  // namespace
}  // namespace ulf::programs_of_others_long_test
