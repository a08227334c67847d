// Tests: core/light_field/exchange/readers/colmap_set, core/light_field/formats/colmap_model,
// core/light_field/formats/colmap_rigs, core/light_field/formats/set_format.
//
// COLMAP's sets of today, whose files are written here byte by byte after COLMAP's source: every camera
// model, rigs, several models, other layouts, and values that are no numbers.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geometry/byte_stream.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/formats/colmap_files.h"
#include "tests/core/light_field/tracked_light_field.h"
#include "tests/support/test_paths.h"

namespace ulf::colmap_set_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix4d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::ScratchFolder;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// ---- Camera models: formulas of COLMAP's src/colmap/sensor/models.h, for a point (u, v, 1). ----

struct Model {
  int number;
  const char* name;
  std::vector<double> parameters;
  std::function<Vector2d(double u, double v)> seen;  // none: refused
  const char* words = "";                            // of the refusal
};

Vector2d Equidistant(double u, double v) {
  const double r = std::hypot(u, v), theta = std::atan(r);
  return Vector2d(u, v) * theta / r;
}

std::vector<Model> EveryModel() {
  const auto fisheye = [](double k1, double k2, double k3, double k4) {
    return [=](double u, double v) {
      const Vector2d p = Equidistant(u, v);
      const double t2 = p.squaredNorm();
      const Vector2d bent = p * (1 + k1 * t2 + k2 * t2 * t2 + k3 * std::pow(t2, 3) + k4 * std::pow(t2, 4));
      return Vector2d(60 * bent.x() + 48, 61 * bent.y() + 32);
    };
  };
  const auto pinhole = [](double u, double v) { return Vector2d(60 * u + 48, 61 * v + 32); };
  const auto one_focal = [](double u, double v) { return Vector2d(60 * u + 48, 60 * v + 32); };
  const char* undistorter = "'colmap image_undistorter'";
  return {{0, "SIMPLE_PINHOLE", {60, 48, 32}, one_focal},
          {1, "PINHOLE", {60, 61, 48, 32}, pinhole},
          {2,
           "SIMPLE_RADIAL",
           {60, 48, 32, 0.1},
           [](double u, double v) {
             return Vector2d(Vector2d(48, 32) + 60 * (1 + 0.1 * (u * u + v * v)) * Vector2d(u, v));
           }},
          {6, "FULL_OPENCV", {60, 61, 48, 32, 0, 0, 0, 0, 0, 0.1, 0, 0}, {}, "'FULL_OPENCV' with k4 k5 k6"},
          {7, "FOV", {60, 61, 48, 32, 0}, pinhole},
          {7, "FOV", {60, 61, 48, 32, 0.9}, {}, "'FOV' with an omega"},
          {8,
           "SIMPLE_RADIAL_FISHEYE",
           {60, 48, 32, 0.02},
           [](double u, double v) {
             const Vector2d p = Equidistant(u, v);
             return Vector2d(Vector2d(48, 32) + 60 * (1 + 0.02 * p.squaredNorm()) * p);
           }},
          {10,
           "THIN_PRISM_FISHEYE",
           {60, 61, 48, 32, 0.02, -0.01, 0, 0, 0.003, -0.002, 0, 0},
           fisheye(0.02, -0.01, 0.003, -0.002)},
          {10, "THIN_PRISM_FISHEYE", {60, 61, 48, 32, 0, 0, 0, 0, 0, 0, 0, 0.001}, {}, "with p1 p2 sx1 sy1"},
          {11,
           "RAD_TAN_THIN_PRISM_FISHEYE",
           {60, 61, 48, 32, 0.02, -0.01, 0.003, -0.002, 0, 0, 0, 0, 0, 0, 0, 0},
           fisheye(0.02, -0.01, 0.003, -0.002)},
          {11,
           "RAD_TAN_THIN_PRISM_FISHEYE",
           {60, 61, 48, 32, 0, 0, 0, 0, 0.001, 0, 0, 0, 0, 0, 0, 0},
           {},
           "COLMAP 3.11 or later"},
          {12, "SIMPLE_DIVISION", {60, 48, 32, 0}, one_focal},
          {12, "SIMPLE_DIVISION", {60, 48, 32, -0.1}, {}, "'SIMPLE_DIVISION' with a k"},
          {13, "DIVISION", {60, 61, 48, 32, -0.1}, {}, "COLMAP 4.0 or later"},
          {14,
           "SIMPLE_FISHEYE",
           {60, 48, 32},
           [](double u, double v) { return Vector2d(Vector2d(48, 32) + 60 * Equidistant(u, v)); }},
          {15, "FISHEYE", {60, 61, 48, 32}, fisheye(0, 0, 0, 0)},
          {16, "EUCM", {60, 61, 48, 32, 0, 1.2}, pinhole},
          {16, "EUCM", {60, 61, 48, 32, 0.6, 1.2}, {}, undistorter},
          {17, "EQUIRECTANGULAR", {96, 64}, {}, "panorama_sfm.py"},
          {18, "TOMORROWS", {60}, {}, "0 to 17"}};
}

std::string CamerasBinOf(const Model& model) {
  ByteWriter out;
  out.Put(std::uint64_t{1});
  out.Put(std::uint32_t{1});
  out.Put(static_cast<std::int32_t>(model.number));
  out.Put(std::uint64_t{96});
  out.Put(std::uint64_t{64});
  for (const double parameter : model.parameters) out.Put(parameter);
  return std::move(out.bytes());
}

TEST(ColmapCameras, EveryModelIsReadOrNamed) {
  const ScratchFolder scratch;
  for (const Model& model : EveryModel()) {
    std::ofstream(scratch / "cameras.bin", std::ios::binary) << CamerasBinOf(model);
    std::ofstream(scratch / "images.bin", std::ios::binary) << std::string(8, '\0');
    const auto binary = [&] {
      const auto camera = ReadColmapBinary(scratch.path()).cameras.at(0);
      return FromColmapCamera(camera, "here");
    };
    const auto text = [&] {
      std::istringstream row(fmt::format("{} 96 64 {}", model.name, fmt::join(model.parameters, " ")));
      return ReadColmapCamera(row, "here");
    };
    for (const std::function<CameraModel()>& read : {std::function<CameraModel()>(binary), {text}}) {
      if (!model.seen) {
        EXPECT_THAT(read, ThrowsMessage<Error>(HasSubstr(model.words))) << model.name;
        continue;
      }
      for (const Vector2d& at : {Vector2d(0.3, -0.2), Vector2d(-0.4, 0.45)}) {
        const auto img = read().ImgFromCam({at.x(), at.y(), 1});
        ASSERT_TRUE(img) << model.name;
        EXPECT_LT((*img - model.seen(at.x(), at.y())).norm(), 1e-9) << model.name;
      }
    }
  }
}

// ---- A set: the photographs and the model of a light field. ----

class ColmapModels : public testing::TestWithParam<bool> {
 protected:
  ColmapModels()
      : source_(test::TrackedLightField(scratch_ / "lf", {test::Straight()}, 6)), model_(ToColmap(source_)) {
    fs::copy(scratch_ / "lf/images", set() / "images", fs::copy_options::recursive);
    for (ColmapReconstruction::Image& image : model_.images) image.name = fs::path(image.name).filename();
  }
  fs::path set() const {
    fs::create_directories(scratch_ / "set");
    return scratch_ / "set";
  }
  std::string ending() const { return GetParam() ? ".bin" : ".txt"; }
  void Write(const ColmapReconstruction& model, const fs::path& folder) const {
    fs::create_directories(folder);
    const ColmapFiles files = GetParam() ? ToColmapBinary(model) : ToColmapText(model);
    std::ofstream(folder / ("cameras" + ending()), std::ios::binary) << files.cameras;
    std::ofstream(folder / ("images" + ending()), std::ios::binary) << files.images;
    std::ofstream(folder / ("points3D" + ending()), std::ios::binary) << files.points3d;
  }
  // The model with its first images alone.
  ColmapReconstruction First(std::size_t images) const {
    ColmapReconstruction part = model_;
    part.images.resize(images);
    part.points.clear();
    return part;
  }
  LightField Read(const fs::path& place) const { return ReadPosedSet(place, {}, {}).light_field; }
  LightField Read() const { return Read(set()); }
  void ExpectOurPoses(const LightField& read, std::size_t views) const {
    ASSERT_EQ(read.views.size(), views);
    for (std::size_t i = 0; i < views; ++i)
      EXPECT_LT((read.views[i].cam_from_world.Matrix() - source_.views[i].cam_from_world.Matrix()).norm(),
                1e-9);
  }
  ScratchFolder scratch_;
  LightField source_;
  ColmapReconstruction model_;
};
INSTANTIATE_TEST_SUITE_P(Formats, ColmapModels, testing::Bool(),
                         [](const auto& binary) { return binary.param ? "Binary" : "Text"; });

TEST_P(ColmapModels, OfSeveralModelsTheLargestIsRead) {
  Write(First(2), set() / "sparse/0");
  Write(First(5), set() / "sparse/2");
  Write(First(4), set() / "sparse/10");
  const LightField read = Read();
  ExpectOurPoses(read, 5);
  EXPECT_THAT(read.doubts,
              Contains(AllOf(HasSubstr("several models"), HasSubstr("sparse/2 with 5 images; give"),
                             HasSubstr("sparse/0 with 2 images, "), HasSubstr("sparse/10 with 4 images"))));
  EXPECT_EQ(Read(set() / "sparse").views.size(), 5u);
  EXPECT_EQ(Read(set() / "sparse/0").views.size(), 2u) << "the one that was asked for";
}

TEST_P(ColmapModels, AreFoundInEveryLayout) {
  for (const char* place : {"colmap/sparse/0", "sparse", "sparse/3", "dense/0/sparse", "dense/sparse", "0"}) {
    Write(model_, set() / place);
    ExpectOurPoses(Read(), 6);
    const fs::path first = set() / *fs::path(place).begin();
    ExpectOurPoses(Read(first), 6);
    ExpectOurPoses(Read(set() / place), 6);
    fs::remove_all(first);
  }
  // Photographs of the model's own layout come before those around it.
  Write(model_, set() / "dense/0/sparse");
  fs::create_directories(set() / "dense/0/images");
  fs::copy(set() / "images" / model_.images[0].name, set() / "dense/0/images");
  EXPECT_EQ(Read().views.size(), 1u);
  fs::remove_all(set() / "dense");
  // convert.py measures the photographs in input, and keeps its pinhole pictures in images.
  fs::copy(set() / "images", set() / "input");
  Write(model_, set() / "distorted/sparse/0");
  for (const fs::path& given : {set(), set() / "distorted", set() / "distorted/sparse/0"})
    EXPECT_EQ(Read(given).root.filename(), "input") << given;
}

TEST_P(ColmapModels, OtherFoldersAreFoundByNames) {
  Write(model_, set() / "sparse/0");
  // A folder of the usual name with other photographs does not stand before the right one.
  fs::rename(set() / "images", set() / "rgb");
  fs::create_directories(set() / "images");
  fs::copy(set() / "rgb" / model_.images[0].name, set() / "images/elsewhere.png");
  EXPECT_EQ(Read().root.filename(), "rgb");
  fs::remove_all(set() / "images");
  for (const char* map : {"masks", "depth"}) fs::copy(set() / "rgb", set() / map);
  EXPECT_EQ(Read().root.filename(), "rgb");
  fs::copy(set() / "rgb", set() / "left");  // which?
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("with images")));
}

TEST_P(ColmapModels, AreFoundInFoldersBelow) {
  for (const char* place : {"sfm", "outputs/sfm_superpoint+superglue", "a/b/sparse/0"}) {
    Write(model_, set() / place);
    const LightField read = Read();
    ExpectOurPoses(read, 6);
    EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("holds no set itself")));
    EXPECT_EQ(read.root, set() / "images");
    ExpectOurPoses(Read(set() / place), 6);
    fs::remove_all(set() / *fs::path(place).begin());
  }
  // Names may count from a folder around all.
  for (ColmapReconstruction::Image& image : model_.images) image.name = "mapping/" + image.name;
  fs::rename(set() / "images", set() / "mapping");
  Write(model_, set() / "outputs/sfm");
  ExpectOurPoses(Read(), 6);
  fs::remove_all(set() / "outputs");
  for (const char* place : {"first/sparse/0", "second/sparse/0"}) Write(model_, set() / place);
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(AllOf(HasSubstr("first (colmap), "),
                                                          HasSubstr("second (colmap); give the folder"))));
}

// Windows begins text with a mark and ends lines with two characters; people indent.
TEST_P(ColmapModels, TextByHandOrOfWindowsIsRead) {
  if (GetParam()) return;
  Write(model_, set() / "sparse/0");
  for (const char* file : {"cameras.txt", "images.txt", "points3D.txt"}) {
    std::string text = "\xEF\xBB\xBF";
    std::istringstream lines("  # mine\n \t\n" + ReadWholeFile(set() / "sparse/0" / file));
    for (std::string line; std::getline(lines, line);) text += line + " \t\r\n";
    std::ofstream(set() / "sparse/0" / file, std::ios::binary) << text;
  }
  Write(First(3), set() / "sparse/1");
  const LightField read = Read(set() / "sparse/0");
  ExpectOurPoses(read, 6);
  EXPECT_EQ(read.points.size(), source_.points.size());
  EXPECT_THAT(Read().doubts, Contains(HasSubstr("sparse/0 with 6 images"))) << "counted without reading it";
}

// ---- Photographs in a folder for each camera. ----

class ColmapFolders : public ColmapModels {
 protected:
  // The photographs left/0.png to left/2.png and right/0.png to right/2.png.
  ColmapFolders() {
    for (std::size_t i = 0; i < 6; ++i) {
      std::string& name = model_.images[i].name;
      const std::string moved = fmt::format("{}/{}.png", i < 3 ? "left" : "right", i % 3);
      fs::create_directories((set() / "images" / moved).parent_path());
      fs::rename(set() / "images" / name, set() / "images" / moved);
      name = moved;
    }
    Write(model_, set() / "sparse/0");
  }
};
INSTANTIATE_TEST_SUITE_P(Formats, ColmapFolders, testing::Bool(),
                         [](const auto& binary) { return binary.param ? "Binary" : "Text"; });

TEST_P(ColmapFolders, AMissingPhotographIsNotItsNamesake) {
  ExpectOurPoses(Read(), 6);
  fs::remove(set() / "images/left/1.png");
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 5u);
  EXPECT_EQ(read.views[1].image_path, "left/2.png");
  EXPECT_EQ(read.views[3].image_path, "right/1.png");
  EXPECT_LT((read.views[3].cam_from_world.Matrix() - source_.views[4].cam_from_world.Matrix()).norm(), 1e-9);
  EXPECT_THAT(read.doubts, ElementsAre(AllOf(HasSubstr("1 photograph of the model is not in"),
                                             HasSubstr("left/1.png the first"))));
}

TEST_P(ColmapFolders, PhotographsOfOtherFoldersAreSaid) {
  fs::remove_all(set() / "images/right");
  fs::rename(set() / "images/left", set() / "images/middle");
  ColmapReconstruction left = First(3);
  Write(left, set() / "sparse/0");
  EXPECT_THAT(Read().doubts, Contains(HasSubstr("3 photographs taken from other folders than the model "
                                                "names: middle/0.png for left/0.png, ...")));
}

TEST_P(ColmapFolders, MasksAreFoundInAnyCase) {
  fs::create_directories(set() / "masks/left");
  cv::imwrite((set() / "masks/left/1.PNG.png").string(), cv::Mat(2, 2, CV_8UC1, 255.0));
  cv::imwrite((set() / "images/right/dynamic_mask_2.png").string(), cv::Mat(2, 2, CV_8UC1, 0.0));
  const LightField read = Read();
  EXPECT_EQ(read.views[1].mask_path, "../masks/left/1.PNG.png");
  EXPECT_EQ(read.views[5].mask_path, "right/dynamic_mask_2.png");
  EXPECT_TRUE(read.views[5].mask_marks_unused);
  EXPECT_EQ(read.views[0].mask_path, "");
}

// ---- Rigs. ----

// The bytes or words of rigs and frames, one value after another.
class Values {
 public:
  explicit Values(bool binary) : binary_(binary) {}
  template <typename T>
  void Put(const T& value) {
    binary_ ? bytes_.Put(value) : void(text_ += fmt::format("{} ", value));
  }
  void PutPose(const Matrix4d& pose) {
    const Quaterniond q(Eigen::Matrix3d(pose.topLeftCorner<3, 3>()));
    for (const double number : {q.w(), q.x(), q.y(), q.z(), pose(0, 3), pose(1, 3), pose(2, 3)}) Put(number);
  }
  void PutCamera(std::uint32_t id) {
    binary_ ? bytes_.Put(std::int32_t{0}) : void(text_ += "CAMERA ");
    Put(id);
  }
  void PutCount(std::uint64_t count) {  // of rigs or frames
    binary_ ? bytes_.Put(count) : void(text_ += "# a comment\n");
  }
  void EndRow() { text_ += "\n"; }
  std::string contents() { return binary_ ? bytes_.bytes() : text_; }

 private:
  bool binary_;
  ByteWriter bytes_;
  std::string text_;
};

Matrix4d Turned(double angle, const Vector3d& axis, const Vector3d& shift) {
  Matrix4d matrix = Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  matrix.topRightCorner<3, 1>() = shift;
  return matrix;
}

// A rig of two cameras takes three frames: images 3, 5, 7 by the reference, 9, 11, 13 by the other.
struct DrawnRig {
  Matrix4d other_from_rig = Turned(0.4, {1, 2, 3}, {-0.2, 0.03, 0.01});
  std::vector<Matrix4d> rig_from_world{Turned(0.1, {0, 1, 0}, {1, 2, 3}), Turned(-0.7, {1, 0, 1}, {0, -1, 2}),
                                       Turned(2, {1, 1, 0}, {3, 0, 1})};
  std::string rigs, frames;
  explicit DrawnRig(bool binary) {
    Values of_rigs(binary), of_frames(binary);
    of_rigs.PutCount(1);
    of_rigs.Put(std::uint32_t{7});
    of_rigs.Put(std::uint32_t{3});  // sensors
    of_rigs.PutCamera(2);
    of_rigs.PutCamera(1);
    of_rigs.Put(std::uint8_t{1});
    of_rigs.PutPose(other_from_rig);
    of_rigs.PutCamera(3);
    of_rigs.Put(std::uint8_t{0});  // without a pose
    of_rigs.EndRow();
    of_frames.PutCount(rig_from_world.size());
    for (std::uint32_t i = 0; i < rig_from_world.size(); ++i) {
      of_frames.Put(100 + i);
      of_frames.Put(std::uint32_t{7});
      of_frames.PutPose(rig_from_world[i]);
      of_frames.Put(std::uint32_t{2});  // images
      of_frames.PutCamera(2);
      of_frames.Put(std::uint64_t{3 + 2 * i});
      of_frames.PutCamera(1);
      of_frames.Put(std::uint64_t{9 + 2 * i});
      of_frames.EndRow();
    }
    rigs = of_rigs.contents();
    frames = of_frames.contents();
  }
};

TEST_P(ColmapModels, EveryCameraGetsItsPoseByItsRig) {
  const DrawnRig drawn(GetParam());
  ColmapReconstruction::Camera other = model_.cameras[0];
  other.id = 2;
  model_.cameras.push_back(other);
  for (std::size_t i = 0; i < 3; ++i) model_.images[i].camera = 2;
  model_.points.clear();
  Write(model_, set() / "sparse/0");
  std::ofstream(set() / "sparse/0" / ("rigs" + ending()), std::ios::binary) << drawn.rigs;
  ExpectOurPoses(Read(), 6);  // without frames COLMAP reads no rigs
  std::ofstream(set() / "sparse/0" / ("frames" + ending()), std::ios::binary) << drawn.frames;
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 6u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT((read.views[i].cam_from_world.Matrix() - drawn.rig_from_world[i]).norm(), 1e-9);
    EXPECT_LT(
        (read.views[i + 3].cam_from_world.Matrix() - drawn.other_from_rig * drawn.rig_from_world[i]).norm(),
        1e-9);
  }
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("6 images have another pose by rigs and frames")));
  // COLMAP's own files agree, and need no word.
  for (std::size_t i = 0; i < 6; ++i) model_.images[i].cam_from_world = read.views[i].cam_from_world;
  Write(model_, set() / "sparse/0");
  EXPECT_THAT(Read().doubts, IsEmpty());
}

TEST_P(ColmapModels, CutOrSenselessRigsAreNamed) {
  const DrawnRig drawn(GetParam());
  Write(model_, set() / "sparse/0");
  const auto write = [&](const std::string& rigs, const std::string& frames) {
    std::ofstream(set() / "sparse/0" / ("rigs" + ending()), std::ios::binary) << rigs;
    std::ofstream(set() / "sparse/0" / ("frames" + ending()), std::ios::binary) << frames;
  };
  for (const double part : {0.3, 0.6, 0.95}) {
    write(drawn.rigs.substr(0, static_cast<std::size_t>(part * static_cast<double>(drawn.rigs.size()))),
          drawn.frames);
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("rigs" + ending())));
    write(drawn.rigs,
          drawn.frames.substr(0, static_cast<std::size_t>(part * static_cast<double>(drawn.frames.size()))));
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("frames" + ending())));
  }
}

// ---- Values that are none. ----

TEST_P(ColmapModels, PosesThatAreNoneAreNamed) {
  for (const auto& [w, x] : std::initializer_list<std::pair<double, double>>{{0, 0}, {1, kNan}}) {
    ColmapReconstruction bad = model_;
    bad.images[2].cam_from_world = {Quaterniond(w, 0, 0, 0), {x, 0, 0}};
    Write(bad, set() / "sparse/0");
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("images" + ending())));
  }
}

TEST_P(ColmapModels, QuaternionsOfAnyLengthAreNormalised) {
  for (ColmapReconstruction::Image& image : model_.images) image.cam_from_world.rotation.coeffs() *= 1.37;
  Write(model_, set() / "sparse/0");
  const LightField read = Read();
  ExpectOurPoses(read, 6);
  EXPECT_THAT(read.doubts, ElementsAre(AllOf(HasSubstr("6 quaternions"), HasSubstr("0.37"))));
}

TEST_P(ColmapModels, ImagesMayBeNumberedFromZero) {
  for (ColmapReconstruction::Image& image : model_.images) image.id = (image.id - 3) / 2;
  model_.points.clear();
  Write(model_, set() / "sparse/0");
  ExpectOurPoses(Read(), 6);
}

// As COLMAP's image_undistorter writes observations that leave the picture.
TEST_P(ColmapModels, ObservationsWithoutAPlaceAreLeftOut) {
  model_.images[1].points[0].in_img = {kNan, kNan};
  model_.points[5].position.x() = kNan;
  Write(model_, set() / "sparse/0");
  if (!GetParam()) {  // COLMAP cannot read it there, either
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("points3D.txt")));
    model_.points[5].position.x() = 0;
    Write(model_, set() / "sparse/0");
  }
  const LightField read = Read();
  EXPECT_EQ(read.points.size(), source_.points.size() - GetParam());
  EXPECT_THAT(read.doubts,
              Contains(HasSubstr("1 observation whose place in the image is not finite: left out")));
  if (GetParam()) {
    EXPECT_THAT(read.doubts, Contains(HasSubstr("1 point whose position is not finite: left out")));
  }
  for (const ScenePoint& point : read.points)
    for (const ViewObservation& seen : point.track) EXPECT_TRUE(seen.in_img.allFinite());
}

TEST_P(ColmapModels, FewOrEqualViewsAreTaken) {
  for (const std::size_t images : {1, 2}) {
    Write(First(images), set() / "sparse/0");
    ExpectOurPoses(Read(), images);
    const fs::path out = scratch_ / fmt::format("out{}", images);
    EXPECT_EQ(Import(set(), out, {.subject = Subject{{0, 0, 3}, 0.5}}).light_field.views.size(), images);
  }
  for (ColmapReconstruction::Image& image : model_.images)
    image.cam_from_world = model_.images[0].cam_from_world;
  model_.points.clear();
  Write(model_, set() / "sparse/0");
  EXPECT_EQ(Read().views.size(), 6u);
  EXPECT_THAT([&] { Import(set(), scratch_ / "same", {}); }, ThrowsMessage<Error>(HasSubstr("subject")));
  EXPECT_FALSE(fs::exists(scratch_ / "same"));
}

}  // namespace
}  // namespace ulf::colmap_set_test
