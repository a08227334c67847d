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
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/image/undistortion.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/core/light_field/tracked_light_field.h"
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

// ---- Loaders of others, on exports whose truth is written beside them. ----

CameraModel OffTheMiddle() {
  CameraModel camera = test::Straight();
  camera.cx += 7.3;
  camera.cy -= 4.1;
  return camera;
}
// Held upright among landscape.
CameraModel Upright() { return {64, 96, 90, 91, 30.4, 49.7}; }

struct LensSet {
  const char* name;
  std::vector<CameraModel> cameras;
  bool one_kind, sixth_order;
};
const LensSet kLensSets[] = {
    {"pinhole", {test::Straight()}, true, false},
    {"off_the_middle", {OffTheMiddle()}, true, false},
    {"opencv", {test::Lens()}, true, false},
    {"full_opencv", {test::SixthOrder()}, true, true},
    {"fisheye", {test::Fisheye()}, true, false},
    {"several", {test::Straight(), test::Lens(), Upright()}, true, false},
    {"mixed", {test::Lens(), test::Fisheye()}, false, false},
    {"every", {test::Straight(), test::Lens(), test::SixthOrder(), test::Fisheye(), Upright()}, false, true},
};

struct NamedForm {
  const char* name;
  const char* form;  // as the loaders know it
  ExportForm export_form;
};
constexpr NamedForm kNamedForms[] = {{"colmap_text", "colmap", ExportForm::kColmapText},
                                     {"colmap_binary", "colmap", ExportForm::kColmapBinary},
                                     {"nerfstudio", "nerfstudio", ExportForm::kNerfstudio},
                                     {"instant_ngp", "instant-ngp", ExportForm::kInstantNgp},
                                     {"nerf_synthetic", "nerf-synthetic", ExportForm::kNerfSynthetic},
                                     {"metashape", "metashape", ExportForm::kMetashape}};

// Pixels over the whole picture at several depths, but for those more than 70 degrees off the axis.
json PointsSeen(const View& view, const CameraModel& camera) {
  json points = json::array();
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  for (int row = 0; row < 5; ++row)
    for (int column = 0; column < 5; ++column) {
      const Eigen::Vector2d pixel((0.03 + 0.235 * column) * camera.width,
                                  (0.03 + 0.235 * row) * camera.height);
      const auto ray = camera.RayFromImg(pixel);
      if (!ray || ray->normalized().z() < std::cos(70 * M_PI / 180)) continue;
      const Vector3d at = world_from_cam * (*ray / ray->z() * (2 + 0.1 * row + 0.3 * column));
      points.push_back({at.x(), at.y(), at.z(), pixel.x(), pixel.y()});
    }
  return points;
}

void WriteTruth(const LightField& source, const std::vector<CameraModel>& cameras, const NamedForm& form,
                const fs::path& file) {
  json truth{{"form", form.form}, {"views", json::array()}, {"points", json::array()}};
  for (const View& view : source.views) {
    json pose = json::array();
    const Eigen::Matrix4d matrix = view.cam_from_world.Matrix();
    for (int r = 0; r < 4; ++r) pose.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)});
    truth["views"].push_back({{"stem", fs::path(view.image_path).stem().string()},
                              {"cam_from_world", pose},
                              {"points", PointsSeen(view, cameras[static_cast<std::size_t>(view.camera)])}});
  }
  for (const ScenePoint& point : source.points)
    truth["points"].push_back(
        {point.position_in_world.x(), point.position_in_world.y(), point.position_in_world.z()});
  WriteFileAtomically(file, JsonText(truth));
}

void ExportWithTruth(const LightField& source, const LensSet& set, bool undistort, const fs::path& folder) {
  for (const NamedForm& form : kNamedForms) {
    const bool as_recorded = !undistort && form.export_form != ExportForm::kNerfSynthetic;
    if (as_recorded && ((form.export_form == ExportForm::kNerfstudio && !set.one_kind) ||
                        (form.export_form == ExportForm::kInstantNgp && set.sixth_order)))
      continue;  // refused
    if (undistort && form.export_form == ExportForm::kNerfSynthetic) continue;
    const fs::path out =
        folder / fmt::format("{}_{}{}", form.name, undistort ? "undistorted_" : "", set.name);
    const ExportSummary summary =
        ExportLightField(source, out, {.form = form.export_form, .undistort = undistort});
    std::vector<CameraModel> cameras = source.cameras;
    for (std::size_t i = 0; i < summary.cameras.size(); ++i) cameras[i] = summary.cameras[i].to;
    WriteTruth(source, cameras, form, out.string() + ".json");
  }
}

std::vector<std::string> LinesIn(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    if (!line.empty() && line[0] != '#') lines.push_back(line);
  return lines;
}

// The verdicts of docs/exchange.md, one by one, are in loaders/verdicts.txt.
TEST(LoadersOfOthers, ReadWhatIsExportedForThem) {
  const char* loaders = std::getenv("ULF_LOADERS");
  if (!loaders)
    GTEST_SKIP() << "loaders of others were not run: set ULF_LOADERS to a folder with the checkouts that "
                    "tests/commands/light_field/loaders/checkouts.txt names";
  const ScratchFolder scratch;
  const fs::path exports = scratch / "exports";
  MakeFolder(exports);
  for (const LensSet& set : kLensSets) {
    const LightField source = test::TrackedLightField(scratch / set.name, set.cameras, 10, true);
    ExportWithTruth(source, set, false, exports);
    if (std::string(set.name) == "every") ExportWithTruth(source, set, true, exports);
  }
  const fs::path out = scratch / "verdicts", errors = scratch / "errors";
  const std::string command = fmt::format("/usr/bin/python3 " LOADERS_OF_OTHERS " '{}' '{}' >'{}' 2>'{}'",
                                          loaders, exports.string(), out.string(), errors.string());
  EXPECT_EQ(std::system(command.c_str()), 0) << ReadWholeFile(errors);
  std::map<std::string, std::string> expected;
  for (const std::string& line : LinesIn(ReadWholeFile(LOADERS_VERDICTS)))
    expected[line.substr(0, line.find(": "))] = line.substr(line.find(": ") + 2);
  const std::vector<std::string> lines = LinesIn(ReadWholeFile(out));
  EXPECT_FALSE(lines.empty()) << loaders << " holds none of the checkouts";
  for (const std::string& line : lines) {
    std::printf("%s\n", line.c_str());
    const std::string what = line.substr(0, line.find(": "));
    EXPECT_EQ(line.substr(line.find(": ") + 2), expected[what]) << what;
  }
  if (const char* keep = std::getenv("ULF_LOADERS_KEEP"))
    fs::copy(exports, keep, fs::copy_options::recursive);
}

}  // namespace
}  // namespace ulf::programs_of_others_long_test
