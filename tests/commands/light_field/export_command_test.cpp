// Tests: commands/light_field/export_command, commands/light_field/export_files,
// commands/light_field/export_scene, commands/light_field/export_splat, commands/light_field/measured_points,
// core/light_field/exchange/export_light_field, core/light_field/exchange/writers/colmap_folder.
//
// `ulf export` on photographs: its points come from them, and COLMAP itself takes what it writes; and the
// photographs of a rig of COLMAP.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <regex>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/png_picture.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/points/point_io.h"
#include "core/light_field/points/point_tracks.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/core/light_field/reader_rules.h"
#include "tests/core/light_field/tracked_light_field.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/refine/refine_input.h"
#include "tracking/refine/triangulate.h"

namespace ulf::export_command_test {
namespace {

namespace fs = std::filesystem;
using test::ColmapRead;
using test::ReadAsColmap;
using test::RunUlf;
using test::ScratchFolder;
using test::TexturedRoom;
using test::TrackedLightField;
using testing::HasSubstr;
using testing::Not;

#ifdef ULF_MANY_VIEWS
constexpr int kViews = 60;
const CameraModel kLens{
    640, 480, 520, 521, 318.2, 243.1, Distortion::kRadialTangential, {-0.12, 0.03, 0.0006, -0.0004, 0}};
#else
constexpr int kViews = 10;
const CameraModel kLens{
    320, 240, 260, 261, 158.7, 122.1, Distortion::kRadialTangential, {-0.12, 0.03, 0.0006, -0.0004, 0}};
#endif

// The room as this lens shows it.
Image Seen(const TexturedRoom& room, const Rigid3& cam_from_world, std::uint64_t id) {
  CameraModel wide = CameraModel::Pinhole(kLens.width + 160, kLens.height + 120, kLens.fx);
  Image image = room.Take(cam_from_world, id, wide).image;
  cv::Mat x(kLens.height, kLens.width, CV_32F), y(kLens.height, kLens.width, CV_32F);
  for (int v = 0; v < kLens.height; ++v)
    for (int u = 0; u < kLens.width; ++u) {
      const Eigen::Vector2d img = *wide.ImgFromCam(*kLens.RayFromImg({u + 0.5, v + 0.5}));
      x.at<float>(v, u) = static_cast<float>(img.x() - 0.5);
      y.at<float>(v, u) = static_cast<float>(img.y() - 0.5);
    }
  cv::Mat seen;
  cv::remap(image.pixels, seen, x, y, cv::INTER_CUBIC);
  cv::cvtColor(seen, seen, cv::COLOR_GRAY2BGR);
  cv::multiply(seen, cv::Scalar(0.4, 0.7, 1), seen);  // in a reddish light
  return {seen, Transfer::kSrgb};
}

class ExportCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch_ = new ScratchFolder;
    const TexturedRoom room({.seed = 4});
    CaptureHeader header;
    header.camera = kLens;
    LightFieldWriter writer = LightFieldWriter::Create(Dir(), header);
    for (int i = 0; i < kViews; ++i) {
      View view;
      view.cam_from_world = TexturedRoom::HandAt(12 * i);
      Frame frame;
      frame.image = Seen(room, view.cam_from_world, static_cast<std::uint64_t>(i));
      writer.AddView(frame, view);
    }
    writer.SetSubject({{0, 0, 3}, 0.5});
    writer.Close(1);
    fs::copy(Dir(), *scratch_ / "bare", fs::copy_options::recursive);
    const LightField& light_field = writer.Contents();
    TriangulationResult result = TriangulateViews(RefineInputOf(light_field), {.features = 1000});
    writer.SetPoints(WithViewIds(std::move(result.points), light_field));
    writer.Close(1);
  }
  static void TearDownTestSuite() { delete scratch_; }
  static fs::path Dir() { return *scratch_ / "lf"; }
  static fs::path Bare() { return *scratch_ / "bare"; }  // the same without points
  static nlohmann::json Export(const std::string& arguments, const fs::path& out,
                               const fs::path& dir = Dir()) {
    const auto run = RunUlf("export " + arguments + " " + dir.string() + " -o " + out.string() + " --json");
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return JsonOrDiscarded(run.output);
  }
  static void ExpectOurPoses(const ColmapRead& model, double most, const fs::path& dir = Dir()) {
    const LightField light_field = ReadLightField(dir);
    ASSERT_EQ(model.images.size(), light_field.views.size());
    for (const auto& [id, image] : model.images) {
      const auto view = std::find_if(light_field.views.begin(), light_field.views.end(),
                                     [&, &name = image.name](const View& v) {
                                       return fs::path(v.image_path).stem() == fs::path(name).stem();
                                     });
      ASSERT_NE(view, light_field.views.end()) << image.name;
      EXPECT_LT((image.rotation.toRotationMatrix() - view->cam_from_world.RotationMatrix()).norm(), most);
      EXPECT_LT((image.translation - view->cam_from_world.translation).norm(), most);
    }
  }
  static ScratchFolder* scratch_;
};
ScratchFolder* ExportCommand::scratch_ = nullptr;

TEST_F(ExportCommand, MeasuresThePointsOfASetThatHasNone) {
  ASSERT_TRUE(ReadLightField(Bare()).points.empty());
  const ScratchFolder scratch;
  const auto report = Export("colmap --undistort --binary", scratch / "out", Bare());
  EXPECT_GT(report["points"], 500);
  EXPECT_GT(report["observations"], 5 * report["points"].get<int>());
  EXPECT_LT(report["mean_error_px"], 0.3);
  EXPECT_LT(report["pose_error_px"], 1);
  const ColmapRead model = ReadAsColmap(scratch / "out/sparse/0");
  EXPECT_EQ(model.points.size(), report["points"]);
  // On the wall and the panels, whose places are known.
  std::size_t near = 0;
  for (const auto& [id, point] : model.points) near += point.position.z() > 1.5 && point.position.z() < 4.5;
  EXPECT_GT(near, 0.99 * static_cast<double>(model.points.size()));
  // Each as red, green and blue as one of the photographs that show it, where it shows it.
  std::map<long, cv::Mat> photographs;
  std::size_t alike = 0;
  for (const auto& [id, point] : model.points) {
    bool is_alike = false;
    for (const auto& [image_id, index] : point.track) {
      const ColmapRead::Image& image = model.images.at(image_id);
      cv::Mat& pixels = photographs[image_id];
      if (pixels.empty()) pixels = cv::imread((scratch / "out/images" / image.name).string());
      const Eigen::Vector2d& at = image.places[static_cast<std::size_t>(index)];
      cv::Mat pixel;
      cv::getRectSubPix(pixels, {1, 1}, {static_cast<float>(at.x() - 0.5), static_cast<float>(at.y() - 0.5)},
                        pixel);
      const auto bgr = pixel.at<cv::Vec3b>(0, 0);
      is_alike |= (Eigen::Vector3i(bgr[2], bgr[1], bgr[0]) - point.rgb).cwiseAbs().maxCoeff() <= 40;
    }
    alike += is_alike;
  }
  EXPECT_GT(alike, 0.95 * static_cast<double>(model.points.size()));
  for (const auto& read : {test::ReadAsInria, test::ReadAsSceneManager, test::ReadAsLichtFeld})
    EXPECT_EQ(read(scratch / "out"), static_cast<std::size_t>(kViews));
  EXPECT_TRUE(ReadLightField(Bare()).points.empty()) << "an export changes nothing";
}

// Photographs that share nothing: what was there is not thrown away for it.
TEST_F(ExportCommand, KeepsPointsWhereNoneCanBeMeasured) {
  const ScratchFolder scratch;
  WriteSample(scratch / "noise", 3);
  for (const char* form : {"nerfstudio", "colmap"}) {
    const auto run = RunUlf(
        fmt::format("export {} {} -o {}", form, (scratch / "noise").string(), (scratch / form).string()));
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.output,
                testing::AllOf(HasSubstr("points: 2\n"), HasSubstr("the points stay as they were")));
  }
  EXPECT_EQ(ReadAsColmap(scratch / "colmap/sparse/0").points.size(), 2u);
  EXPECT_EQ(ReadLightField(scratch / "nerfstudio").points.size(), 2u);
}

TEST_F(ExportCommand, WithoutPointsSaysWhatToDo) {
  const ScratchFolder scratch;
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(80, 60, 70);
  LightFieldWriter writer = LightFieldWriter::Create(scratch / "tiny", header);
  for (int i = 0; i < 3; ++i) {
    Frame frame;
    frame.image = {cv::Mat(60, 80, CV_8UC3, cv::Scalar::all(40 + 10 * i)), Transfer::kSrgb};
    View view;
    view.cam_from_world = TexturedRoom::HandAt(12 * i);
    writer.AddView(frame, view);
  }
  writer.Close(1);
  const auto said = [&](const std::string& form) {
    const std::string out = (scratch / "out").string();
    fs::remove_all(out);
    const auto run = RunUlf("export " + form + " " + (scratch / "tiny").string() + " -o " + out);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return run.output;
  };
  const auto warns = testing::AllOf(HasSubstr("no points: trainers of Gaussians begin"), HasSubstr("80x60"),
                                    HasSubstr("larger photographs"), HasSubstr("--check-poses"));
  for (const char* form : {"nerfstudio", "metashape"})
    EXPECT_THAT(said(form), testing::AllOf(warns, Not(HasSubstr("COLMAP"))));
  EXPECT_THAT(said("colmap"), testing::AllOf(warns, HasSubstr("COLMAP's commands below")));
  EXPECT_THAT(said("colmap --known-points"), HasSubstr("leave --known-points out to measure them"));
  EXPECT_THAT(said("realityscan"), Not(HasSubstr("no points"))) << "it has none";
}

TEST_F(ExportCommand, WritesNothingIntoTheLightField) {
  for (const char* inside : {"", "/out", "/images/../out"}) {
    const auto run = RunUlf("export colmap " + Dir().string() + " -o " + Dir().string() + inside);
    EXPECT_EQ(run.exit_code, 2) << inside;
    EXPECT_THAT(run.errors, HasSubstr("lies in the light field"));
  }
  EXPECT_FALSE(std::filesystem::exists(Dir() / "out"));
}

// TBB would warn of threads beyond the processors of this process.
TEST_F(ExportCommand, IsQuietOnOneProcessor) {
  cpu_set_t allowed;
  ASSERT_EQ(sched_getaffinity(0, sizeof allowed, &allowed), 0);
  int first = 0;
  while (!CPU_ISSET(first, &allowed)) ++first;
  const ScratchFolder scratch;
  for (const std::string threads : {"", " --threads 4"}) {
    const auto run =
        test::RunProgram(fmt::format("taskset -c {} {}", first, std::getenv("ULF_BINARY")),
                         fmt::format("export nerfstudio --known-points {} -o {}{}", Dir().string(),
                                     (scratch / fmt::format("out{}", threads.size())).string(), threads));
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.errors, Not(HasSubstr("TBB")));
  }
}

TEST_F(ExportCommand, SaysWhatItCutAndWhatItFound) {
  const ScratchFolder scratch;
  const auto run = RunUlf("export nerfstudio " + Dir().string() + " --undistort --known-points -o " +
                          (scratch / "out").string());
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("camera 1: "));
  EXPECT_THAT(run.output, HasSubstr("% of the picture is kept"));
  EXPECT_THAT(run.output, HasSubstr("px off (mean)"));
  EXPECT_EQ(test::ReadAsNerfstudio(scratch / "out"), static_cast<std::size_t>(kViews));
  EXPECT_EQ(test::ReadAsInstantNgp(scratch / "out"), static_cast<std::size_t>(kViews));
  const auto again = RunUlf("export nerfstudio " + Dir().string() + " -o " + (scratch / "out").string());
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.errors, HasSubstr("not an empty folder"));
  EXPECT_THAT(again.errors, Not(HasSubstr("reading view"))) << "said before the work";
  EXPECT_EQ(RunUlf("export").exit_code, 2);
}

TEST_F(ExportCommand, WritesTheFormsWithoutPoints) {
  const ScratchFolder scratch;
  for (const std::string form : {"instant-ngp", "nerf-synthetic", "realityscan"}) {
    const auto report = Export(form, scratch / form);
    EXPECT_EQ(report["views"], kViews) << form;
    const auto back = RunUlf("import " + (scratch / form).string() + " --no-check -o " +
                             (scratch / (form + "_back")).string());
    EXPECT_EQ(back.exit_code, 0) << back.errors;
    EXPECT_EQ(ReadLightField(scratch / (form + "_back")).views.size(), static_cast<std::size_t>(kViews));
  }
  EXPECT_THAT(RunUlf("export --help").output,
              testing::AllOf(HasSubstr("metashape"), HasSubstr("gltf"), HasSubstr("quilt")));
  const auto bad =
      RunUlf("export nerf-synthetic " + Dir().string() + " --subject 1,2 -o " + (scratch / "no").string());
  EXPECT_EQ(bad.exit_code, 2);
}

// Eight numbers a line, after comments that say what the times are.
TEST_F(ExportCommand, WritesATrajectoryOfItsPoses) {
  const ScratchFolder scratch;
  EXPECT_EQ(Export("tum", scratch / "numbers.txt")["times"], "numbers");
  WriteSample(scratch / "timed", 3);
  const auto timed = Export("tum", scratch / "times.txt", scratch / "timed");
  EXPECT_EQ(timed["times"], "device");
  EXPECT_EQ(timed["poses"], 3);
  const LightField light_field = ReadLightField(scratch / "timed");
  std::istringstream lines(ReadWholeFile(scratch / "times.txt"));
  std::size_t read = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream numbers(line);
    double time_s = 0;
    Eigen::Vector3d center;
    Eigen::Quaterniond turn;
    numbers >> time_s >> center.x() >> center.y() >> center.z() >> turn.x() >> turn.y() >> turn.z() >>
        turn.w();
    const View& view = light_field.views.at(read++);
    EXPECT_NEAR(time_s, view.device_time_s, 1e-9);
    EXPECT_LT((center - view.CenterInWorld()).norm(), 1e-7);
    EXPECT_LT(
        (turn.toRotationMatrix() * view.cam_from_world.RotationMatrix() - Eigen::Matrix3d::Identity()).norm(),
        1e-7);
  }
  EXPECT_EQ(read, 3u);
  EXPECT_THAT(ReadWholeFile(scratch / "numbers.txt"), HasSubstr("# times are numbers of views"));
  const auto again = RunUlf("export tum " + Dir().string() + " -o " + (scratch / "times.txt").string());
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.errors, HasSubstr("not replaced"));
  EXPECT_EQ(RunUlf("export tum " + Dir().string() + " -o " + (Dir() / "poses.txt").string()).exit_code, 2);
}

TEST_F(ExportCommand, WritesItsPointsAsOneFile) {
  const ScratchFolder scratch;
  const auto report = Export("ply", scratch / "points.ply", Bare());
  const std::vector<ScenePoint> points = ReadPointPly(scratch / "points.ply");
  EXPECT_EQ(points.size(), report["points"]);
  EXPECT_GT(points.size(), 500u);
  std::size_t near = 0, reddish = 0;  // on the wall and the panels, in their light
  for (const ScenePoint& point : points) {
    near += point.position_in_world.z() > 1.5 && point.position_in_world.z() < 4.5;
    reddish += point.rgb[0] >= point.rgb[2];
  }
  EXPECT_GT(near, points.size() * 99 / 100);
  EXPECT_GT(reddish, points.size() * 95 / 100);
  const auto none =
      RunUlf("export ply --known-points " + Bare().string() + " -o " + (scratch / "none.ply").string());
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.errors, HasSubstr("leave --known-points out"));
  EXPECT_FALSE(fs::exists(scratch / "none.ply"));
}

TEST_F(ExportCommand, DrawsAQuiltAndBakesAMesh) {
  const ScratchFolder scratch;
  const auto quilt = Export(
      "quilt --tiles 3x2 --size 96x64 --aspect 1 --cone 6 --proxy plane --field nearest "
      "--renderer reference",
      scratch / "quilt");
  EXPECT_EQ(quilt["tiles"], 6);
  EXPECT_EQ(quilt["file"], "lf_qs3x2a1.png");
  EXPECT_EQ(ReadImageFile((scratch / "quilt/lf_qs3x2a1.png").string()).size(), cv::Size(96, 64));
  const auto unmade = RunUlf("export gltf " + Dir().string() + " -o " + (scratch / "no").string());
  EXPECT_EQ(unmade.exit_code, 1);
  EXPECT_THAT(unmade.errors, HasSubstr("ulf proxy"));
  EXPECT_FALSE(fs::exists(scratch / "no"));
  std::ofstream(scratch / "wall.ply")
      << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "-0.6 -0.6 3\n0.6 -0.6 3\n0.6 0.6 3\n-0.6 0.6 3\n4 0 1 2 3\n";
  const auto baked = Export("gltf --texture 512 --mesh " + (scratch / "wall.ply").string(), scratch / "gltf");
  EXPECT_EQ(baked["cameras"], kViews);
  EXPECT_EQ(baked["of_triangles"], 2);
  EXPECT_GT(baked["triangles"], 20);
  EXPECT_LE(baked["texture"][0], 512);
  for (const char* name : {"lf.glb", "lf_vertex_colors.glb"})
    EXPECT_TRUE(fs::exists(scratch / "gltf" / name));
}

TEST_F(ExportCommand, SplatWritesAFileByItsEnding) {
  const ScratchFolder scratch;
  const auto said = [](const fs::path& light_field, const fs::path& out) {
    return RunUlf("export splat --most 3000 --json " + light_field.string() + " -o " + out.string());
  };
  const fs::path with_mesh = scratch / "lf";
  fs::copy(Dir(), with_mesh, fs::copy_options::recursive);
  std::ofstream(with_mesh / "proxy.ply")
      << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "-6 -6 3\n6 -6 3\n6 6 3\n-6 6 3\n4 0 1 2 3\n";
  for (const char* name : {"vase.ply", "vase.SPZ", "vase.glb"}) {
    const auto run = said(with_mesh, scratch / name);
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const auto report = JsonFromText(run.output);
    EXPECT_GT(report["gaussians"], 300) << name;
    EXPECT_LE(report["gaussians"], 3000) << name;
    EXPECT_EQ(report["bytes"], fs::file_size(scratch / name)) << name;
  }
  const auto again = said(with_mesh, scratch / "vase.ply");
  EXPECT_EQ(again.exit_code, 2);
  const auto other = said(with_mesh, scratch / "vase.splat");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.errors, HasSubstr(".ply, .spz or .glb"));
}

// ---- COLMAP itself (Debian's, without a display or a GPU). ----

struct ByColmap {
  int exit_code = -1;
  std::string output;
};

ByColmap Colmap(const std::string& arguments) {
  const ScratchFolder scratch;
  const std::string file = (scratch / "output").string();
  const int status = std::system(("colmap " + arguments + " >" + file + " 2>&1").c_str());
  return {WEXITSTATUS(status), ReadWholeFile(file)};
}

double Said(const ByColmap& run, const std::string& what) {
  std::smatch number;
  if (!std::regex_search(run.output, number, std::regex(what + ": ([0-9.e+-]+)"))) return -1;
  return std::stod(number[1]);
}

bool HasColmap() { return std::system("command -v colmap >/dev/null") == 0; }

TEST_F(ExportCommand, ColmapAnalysesAndUndistortsIt) {
  ASSERT_TRUE(HasColmap()) << "colmap is not installed: ./run deps";
  const ScratchFolder scratch;
  const ByColmap as_recorded = Colmap("model_analyzer --path " + (Dir() / "sparse/0").string());
  EXPECT_EQ(Said(as_recorded, "Registered images"), kViews) << as_recorded.output;
  EXPECT_GT(Said(as_recorded, "Mean reprojection error"), 0);
  EXPECT_LT(Said(as_recorded, "Mean reprojection error"), 0.5);
  EXPECT_GT(Said(as_recorded, "Observations"), 1000);
  for (const std::string form : {"--binary", ""}) {
    const fs::path out = scratch / ("out" + form);
    const auto report = Export("colmap --known-points " + form, out);
    const ByColmap analysed = Colmap("model_analyzer --path " + (out / "sparse/0").string());
    EXPECT_EQ(analysed.exit_code, 0) << analysed.output;
    EXPECT_EQ(Said(analysed, "Registered images"), kViews);
    EXPECT_EQ(Said(analysed, "Points"), report["points"]);
    EXPECT_EQ(Said(analysed, "Observations"), report["observations"]);
    EXPECT_LT(Said(analysed, "Mean reprojection error"), 0.5);
    EXPECT_GT(Said(analysed, "Mean reprojection error"), 0);
  }
  const fs::path undistorted = scratch / "by_colmap";
  const ByColmap run =
      Colmap("image_undistorter --image_path " + (scratch / "out/images").string() + " --input_path " +
             (scratch / "out/sparse/0").string() + " --output_path " + undistorted.string());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  ExpectOurPoses(ReadAsColmap(undistorted / "sparse"), 1e-9);
}

// The command as it is printed, with features enough for small pictures.
std::string ForSmallPictures(std::string command) {
  if (command.find("feature_extractor") != std::string::npos)
    command +=
        " --SiftExtraction.max_num_features 1500 --SiftExtraction.first_octave 0"
        " --SiftExtraction.num_threads 1";  // else its numbers follow whichever thread is faster
  return command.substr(std::string("colmap ").size());
}

// Leaves poses alone, as COLMAP's manual has it for a model by hand.
void RemovePoints(const fs::path& model) {
  std::ifstream images(model / "images.txt");
  std::string bare;
  int row = 0;
  for (std::string line; std::getline(images, line);)
    bare += line.starts_with('#') || row++ % 2 == 0 ? line + "\n" : "\n";
  WriteFileAtomically(model / "images.txt", bare);
  WriteFileAtomically(model / "points3D.txt", "");
}

TEST_F(ExportCommand, SaysWhichColmapItsRecipeIsFor) {
  const ScratchFolder scratch;
  const std::string rest =
      "export colmap --known-points " + Dir().string() + " -o " + (scratch / "out").string();
  const auto run = test::RunProgram("PATH=/none " + std::string(std::getenv("ULF_BINARY")), rest);
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, testing::AllOf(HasSubstr("for COLMAP 3.13 and later"), HasSubstr("3.12 says"),
                                         HasSubstr("--FeatureExtraction.num_threads 1\n")));
}

TEST_F(ExportCommand, ColmapTriangulatesByItsCommands) {
  ASSERT_TRUE(HasColmap()) << "colmap is not installed: ./run deps";
  const ScratchFolder scratch;
  const fs::path lf = scratch / "lf", out = scratch / "out";
  fs::copy(Bare(), lf, fs::copy_options::recursive);
  ASSERT_EQ(RunUlf("take-back " + lf.string() + " 3 7").exit_code, 0);
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  const auto report = Export("colmap --known-points", out, lf);
  ASSERT_EQ(report["commands"].size(), 4u);
  for (const std::string command : report["commands"]) {
    if (!command.starts_with("colmap ")) {
      EXPECT_EQ(std::system(command.c_str()), 0) << command;
      continue;
    }
    const ByColmap run = Colmap(ForSmallPictures(command));
    ASSERT_EQ(run.exit_code, 0) << command << run.output;
  }
  const ColmapRead model = ReadAsColmap(out / "triangulated");
  ExpectOurPoses(model, 1e-9, lf);
  EXPECT_GT(model.points.size(), 150u);
  const ByColmap analysed = Colmap("model_analyzer --path " + (out / "triangulated").string());
  EXPECT_EQ(analysed.exit_code, 0) << analysed.output;
  EXPECT_GT(Said(analysed, "Mean reprojection error"), 0) << analysed.output;
  EXPECT_LT(Said(analysed, "Mean reprojection error"), 0.5);
  EXPECT_EQ(Said(analysed, "Points"), model.points.size());
  EXPECT_GT(Said(analysed, "Observations"), 2.0 * static_cast<double>(model.points.size()));
  // COLMAP 4 needs the numbers of the database; 3.8 compares them where it keeps the model's points.
  RemovePoints(out / "sparse/0");
  fs::create_directory(scratch / "by_number");
  const ByColmap by_number =
      Colmap("point_triangulator --database_path " + (out / "database.db").string() + " --image_path " +
             (out / "images").string() + " --input_path " + (out / "sparse/0").string() + " --output_path " +
             (scratch / "by_number").string() + " --clear_points 0");
  EXPECT_EQ(by_number.exit_code, 0) << by_number.output;
}

// It leaves a fisheye alone whose coefficients are zero: the light field itself shows it.
TEST(ExportForColmap, AStraightFisheyeIsUndistortedByIt) {
  ASSERT_TRUE(HasColmap()) << "colmap is not installed: ./run deps";
  const ScratchFolder scratch;
  CameraModel fisheye = test::Fisheye();
  fisheye.coefficients = {};
  TrackedLightField(scratch / "lf", {fisheye}, 2);
  const auto exported = RunUlf("export colmap --known-points " + (scratch / "lf").string() + " -o " +
                               (scratch / "out").string());
  ASSERT_EQ(exported.exit_code, 0) << exported.errors;
  EXPECT_THAT(exported.output, HasSubstr("k1 is written as 2e-08"));
  const auto undistorted = [&](const std::string& dir) {
    const ByColmap run = Colmap("image_undistorter --image_path " + (scratch / dir / "images").string() +
                                " --input_path " + (scratch / dir / "sparse/0").string() + " --output_path " +
                                (scratch / ("by_" + dir)).string());
    EXPECT_EQ(run.exit_code, 0) << run.output;
    return ReadAsColmap(scratch / ("by_" + dir) / "sparse").cameras.begin()->second.model;
  };
  EXPECT_EQ(undistorted("lf"), "OPENCV_FISHEYE");
  EXPECT_EQ(undistorted("out"), "PINHOLE");
}

// Two cameras on a bar, drawn where they stand: the photographs themselves say whether poses are right.
TEST(ImportFromColmap, PhotographsFitThePosesByTheirRig) {
  const ScratchFolder scratch;
  const fs::path model = scratch / "set/sparse/0";
  fs::create_directories(scratch / "set/images");
  fs::create_directories(model);
  const TexturedRoom room({.seed = 4});
  const CameraModel camera = CameraModel::Pinhole(320, 240, 260);
  const Rigid3 other_from_rig{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.15, Eigen::Vector3d(0, 1, 0.3).normalized())),
      {-0.25, 0.02, 0.03}};
  const auto numbers = [](const Rigid3& pose) {
    const Eigen::Quaterniond& q = pose.rotation;
    const Eigen::Vector3d& t = pose.translation;
    return fmt::format("{} {} {} {} {} {} {}", q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z());
  };
  std::string images, frames;
  for (int i = 0; i < 4; ++i) {
    const Rigid3 rig_from_world = TexturedRoom::HandAt(15 * i);
    frames +=
        fmt::format("{} 1 {} 2 CAMERA 1 {} CAMERA 2 {}\n", i + 1, numbers(rig_from_world), i + 1, i + 11);
    for (const bool is_other : {false, true}) {
      const std::string name = fmt::format("{}_{}.png", is_other ? "right" : "left", i);
      const Image seen = room.Take(is_other ? other_from_rig * rig_from_world : rig_from_world,
                                   static_cast<std::uint64_t>(i), camera)
                             .image;
      WriteFileAtomically(scratch / "set/images" / name, PngBytes(Srgb8(seen)));
      images += fmt::format("{} 1 0 0 0 0 0 0 {} {}\n\n", i + 1 + 10 * is_other, 1 + is_other, name);
    }
  }
  const std::string lens = "PINHOLE 320 240 260 260 160 120\n";
  WriteFileAtomically(model / "cameras.txt", "1 " + lens + "2 " + lens);
  WriteFileAtomically(model / "images.txt", images);
  WriteFileAtomically(model / "points3D.txt", "");
  WriteFileAtomically(model / "rigs.txt", "1 2 CAMERA 1 CAMERA 2 1 " + numbers(other_from_rig) + "\n");
  WriteFileAtomically(model / "frames.txt", frames);
  const auto run =
      RunUlf("import " + (scratch / "set").string() + " --subject 0,0,3,0.5 -o " + (scratch / "lf").string());
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("the photographs fit the poses of 8 views to 0.")) << run.errors;
}

#ifdef ULF_MANY_VIEWS
// What a hand has gone round is wide enough for a display's own layout: 8 x 6 views over its whole cone.
TEST(ExportOfACapture, IsAQuiltOfFortyEightViews) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "studio").string(), out = (scratch / "quilt").string();
  const auto capture = RunUlf("capture 'sim:studio?seed=21' -o " + dir +
                              " --headless --poses known --subject 0,0,0.07,0.17 --quality fast"
                              " --until-covered 60x40");
  ASSERT_EQ(capture.exit_code, 0) << capture.errors;
  const auto exported = RunUlf("export quilt " + dir + " -o " + out + " --json");
  ASSERT_EQ(exported.exit_code, 0) << exported.errors;
  const auto quilt = JsonFromText(exported.output);
  EXPECT_EQ(quilt["tiles"], 48);
  EXPECT_EQ(quilt["outside"], 0) << "views that lie outside of the recorded ones";
  EXPECT_EQ(quilt["file"], "studio_qs8x6a0.75.png");
  const cv::Mat picture = ReadImageFile(out + "/studio_qs8x6a0.75.png");
  ASSERT_EQ(picture.size(), cv::Size(3360, 3360));
  // From the leftmost view at the bottom left to the rightmost at the top right the subject stays, and turns.
  const cv::Size tile(420, 560);
  const auto at = [&](int column, int row) {
    const cv::Rect middle(column * tile.width + 110, (5 - row) * tile.height + 180, 200, 200);
    cv::Mat small;
    cv::resize(picture(middle), small, {50, 50}, 0, 0, cv::INTER_AREA);
    return small;
  };
  const auto apart = [](const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_L1) / 7500; };
  EXPECT_LT(apart(at(3, 2), at(4, 2)), 0.5 * apart(at(0, 0), at(7, 5)));
  EXPECT_GT(apart(at(0, 0), at(7, 5)), 10);
}
#endif

}  // namespace
}  // namespace ulf::export_command_test
