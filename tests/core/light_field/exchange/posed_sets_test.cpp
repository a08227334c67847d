// Tests: core/light_field/exchange/read_posed_set, core/light_field/formats/posed_set,
// core/light_field/exchange/readers/colmap_set, core/light_field/exchange/readers/llff_set,
// core/light_field/exchange/readers/npy_file, core/light_field/exchange/subject_of_set,
// core/light_field/exchange/readers/set_readers, core/light_field/formats/colmap_files,
// core/light_field/formats/set_format, core/base/binary_file.
//
// The same cameras before the same wall in every format: what is read is what was written, and what is
// damaged is refused by name.
#include "core/base/json_text.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/read_posed_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/files/exr_file.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/exchange/readers/npy_file.h"
#include "core/light_field/exchange/subject_of_set.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/colmap_files.h"
#include "core/light_field/formats/set_format.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/core/light_field/tracked_light_field.h"
#include "tests/support/test_paths.h"

namespace ulf::posed_sets_test {
namespace {

using nlohmann::json;
using test::ScratchFolder;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

constexpr double kNear = 2, kFar = 4;

// Five cameras side by side that all face the same way, before points from kNear to kFar away.
LightField Wall(const CameraModel& camera) {
  LightField wall;
  wall.cameras = {camera};
  for (int i = 0; i < 5; ++i) {
    View view;
    view.id = i + 1;
    view.image_path = fmt::format("images/shot{}.png", i + 1);
    view.cam_from_world =
        Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(0.01 * i, Eigen::Vector3d(1, 2, 3).normalized())),
               {-0.3 * i, 0.02 * i, 0.01}};
    wall.views.push_back(view);
  }
  cv::RNG random(5);
  for (int i = 0; i < 60; ++i) {
    ScenePoint point;
    point.position_in_world = {random.uniform(-0.5, 1.5), random.uniform(-0.6, 0.6),
                               random.uniform(kNear, kFar)};
    point.rgb = {static_cast<std::uint8_t>(i), 2, 3};
    for (const View& view : wall.views)
      if (const auto img = camera.ImgFromCam(view.cam_from_world * point.position_in_world);
          img && camera.Contains(*img))
        point.track.push_back({view.id, *img});
    if (point.track.size() > 1) wall.points.push_back(point);
  }
  return wall;
}

LightField Wall() {
  return Wall(CameraModel{.width = kWidth,
                          .height = kHeight,
                          .fx = 60,
                          .fy = 60,
                          .cx = 31,
                          .cy = 23,
                          .distortion = Distortion::kRadialTangential,
                          .coefficients = {0.02, -0.01, 0, 0, 0}});
}

void WritePhotographs(const LightField& light_field, const fs::path& folder,
                      const cv::Size& size = {kWidth, kHeight}) {
  fs::create_directories(folder);
  for (const View& view : light_field.views) {
    cv::Mat picture = NoiseFrame(view.id).image.pixels;
    if (picture.size() != size) cv::resize(picture, picture, size);
    cv::imwrite((folder / fs::path(view.image_path).filename()).string(), picture);
  }
}

void ExpectSameCameras(const LightField& read, const LightField& written) {
  ASSERT_EQ(read.views.size(), written.views.size());
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    const View &a = read.views[i], &b = written.views[i];
    EXPECT_EQ(fs::path(a.image_path).filename(), fs::path(b.image_path).filename());
    EXPECT_LT((a.cam_from_world.Matrix() - b.cam_from_world.Matrix()).norm(), 1e-9) << a.image_path;
    for (const Eigen::Vector3d& point : {Eigen::Vector3d(0.1, 0.2, 1), Eigen::Vector3d(-0.3, 0.1, 1.2)})
      EXPECT_LT((*read.CameraOf(a).ImgFromCam(point) - *written.CameraOf(b).ImgFromCam(point)).norm(), 1e-9);
  }
}

void ExpectPointsOnTheirObservations(const LightField& light_field, std::size_t points) {
  ASSERT_EQ(light_field.points.size(), points);
  for (const ScenePoint& point : light_field.points) {
    EXPECT_GE(point.track.size(), 2u);
    for (const ViewObservation& seen : point.track) {
      const View& view = light_field.views.at(static_cast<std::size_t>(seen.view_id) - 1);
      EXPECT_LT((*light_field.CameraOf(view).ImgFromCam(view.cam_from_world * point.position_in_world) -
                 seen.in_img)
                    .norm(),
                1e-3);
    }
  }
}

// ---- LLFF ----

struct NpyKind {
  const char* type = "<f8";
  bool by_columns = false;
  int version = 1;
};

std::string Npy(const Eigen::MatrixXd& values, const NpyKind& kind = {}, const std::string& shape = "") {
  std::string header =
      fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': ({}), }}", kind.type,
                  kind.by_columns ? "True" : "False",
                  shape.empty() ? fmt::format("{}, {}", values.rows(), values.cols()) : shape);
  while ((header.size() + 11) % 64 != 0) header += ' ';
  header += '\n';
  std::string bytes = "\x93NUMPY";
  bytes += static_cast<char>(kind.version);
  bytes += '\0';
  bytes += static_cast<char>(header.size() & 255);
  bytes += static_cast<char>(header.size() >> 8);
  if (kind.version > 1) bytes += std::string(2, '\0');
  bytes += header;
  const auto put = [&](double value) {
    const std::string type = kind.type;
    std::string number(type.ends_with('8') ? 8 : 4, '\0');
    const auto narrow = static_cast<float>(value);
    std::memcpy(number.data(), type.ends_with('8') ? static_cast<const void*>(&value) : &narrow,
                number.size());
    if (type.starts_with('>')) std::ranges::reverse(number);
    bytes += number;
  };
  if (kind.by_columns)
    for (Eigen::Index c = 0; c < values.cols(); ++c)
      for (Eigen::Index r = 0; r < values.rows(); ++r) put(values(r, c));
  else
    for (Eigen::Index r = 0; r < values.rows(); ++r)
      for (Eigen::Index c = 0; c < values.cols(); ++c) put(values(r, c));
  return bytes;
}

// Columns down, right, back, centre, (height, width, focal length), then two depths.
Eigen::MatrixXd LlffRows(const LightField& light_field) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(light_field.views.size()), 17);
  for (std::size_t i = 0; i < light_field.views.size(); ++i) {
    const CameraModel& camera = light_field.CameraOf(light_field.views[i]);
    const Eigen::Matrix4d world_from_cam = light_field.views[i].cam_from_world.Inverse().Matrix();
    Eigen::Matrix<double, 3, 5, Eigen::RowMajor> matrix;
    matrix.col(0) = world_from_cam.block<3, 1>(0, 1);
    matrix.col(1) = world_from_cam.block<3, 1>(0, 0);
    matrix.col(2) = -world_from_cam.block<3, 1>(0, 2);
    matrix.col(3) = world_from_cam.block<3, 1>(0, 3);
    matrix.col(4) = Eigen::Vector3d(camera.height, camera.width, camera.fx);
    rows.row(static_cast<Eigen::Index>(i)).head<15>() =
        Eigen::Map<const Eigen::Matrix<double, 1, 15>>(matrix.data());
    rows.row(static_cast<Eigen::Index>(i)).tail<2>() = Eigen::Vector2d(kNear, kFar);
  }
  return rows;
}

class LlffSet : public testing::Test {
 protected:
  LlffSet() : wall_(Wall(CameraModel::Pinhole(kWidth, kHeight, 60))) {
    wall_.points.clear();
    WritePhotographs(wall_, set() / "images");
    Write(Npy(LlffRows(wall_)));
  }
  fs::path set() const { return scratch_ / "set"; }
  fs::path file() const { return set() / "poses_bounds.npy"; }
  void Write(const std::string& bytes) { std::ofstream(file(), std::ios::binary) << bytes; }
  PosedSet Read() { return ReadPosedSet(set(), {}, {}); }
  void ExpectRefused(const std::string& words) {
    EXPECT_THAT([&] { Read(); },
                ThrowsMessage<Error>(AllOf(HasSubstr("poses_bounds.npy"), HasSubstr(words))));
  }
  ScratchFolder scratch_;
  LightField wall_;
};

TEST_F(LlffSet, IsReadWhateverNumbersItIsWrittenIn) {
  EXPECT_EQ(Read().format, "LLFF");
  ExpectSameCameras(Read().light_field, wall_);
  for (const NpyKind& kind : {NpyKind{">f8", false, 1}, {"<f8", true, 2}, {"<f8", false, 3}}) {
    Write(Npy(LlffRows(wall_), kind));
    ExpectSameCameras(Read().light_field, wall_);
  }
  Write(Npy(LlffRows(wall_), {"<f4", false, 1}));
  EXPECT_LT(
      (Read().light_field.views[4].cam_from_world.Matrix() - wall_.views[4].cam_from_world.Matrix()).norm(),
      1e-6);
  EXPECT_EQ(ReadPosedSet(file(), {}, {}).light_field.views.size(), 5u) << "the file itself";
}

TEST_F(LlffSet, OpeningItPointsToTheImport) {
  EXPECT_THAT([&] { ReadLightField(set()); },
              ThrowsMessage<Error>(AllOf(HasSubstr("llff"), HasSubstr("ulf import"))));
}

TEST_F(LlffSet, SubjectLiesAtTheMiddleDisparity) {
  const auto found = FindSubject(Read());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->told_by, "the depth bounds");
  const double middle = 2 / (1 / kNear + 1 / kFar);
  EXPECT_NEAR((wall_.views[2].cam_from_world * found->subject.center_in_world).z(), middle, 0.05);
  const auto run = test::RunUlf("import " + set().string() + " -o " + (scratch_ / "lf").string());
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("LLFF, 5 views"), HasSubstr("by the depth bounds")));
  EXPECT_EQ(ReadLightField(scratch_ / "lf").subject, found->subject);
}

TEST_F(LlffSet, ReducedPhotographsScaleTheCamera) {
  fs::remove_all(set() / "images");
  WritePhotographs(wall_, set() / "images_2", {kWidth / 2, kHeight / 2});
  const PosedSet half = Read();
  EXPECT_EQ(half.light_field.cameras.at(0), wall_.cameras[0].ScaledTo(kWidth / 2, kHeight / 2));
  EXPECT_THAT(half.light_field.doubts, ElementsAre(HasSubstr("resized")));
  WritePhotographs(wall_, set() / "images");
  EXPECT_EQ(Read().light_field.cameras.at(0), wall_.cameras[0]) << "the largest";
  EXPECT_EQ(ReadPosedSet(set(), {}, set() / "images_2").light_field.cameras, half.light_field.cameras);
  const auto run =
      test::RunUlf("import " + set().string() + " --images images_2 -o " + (scratch_ / "lf").string());
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(ReadLightField(scratch_ / "lf").cameras, half.light_field.cameras);
  WritePhotographs(wall_, set() / "images", {kWidth, kHeight - 4});
  ExpectRefused("cropped or turned");
}

TEST_F(LlffSet, DeepPicturesAmongEightBitsKeepTheirLight) {
  cv::Mat deep(kHeight, kWidth, CV_16UC3, cv::Scalar(1000, 2000, 3001));
  cv::imwrite((set() / "images/shot2.png").string(), deep);
  cv::Mat light(kHeight, kWidth, CV_32FC3, cv::Scalar(0.1, 0.2, 3.5));
  WriteFileAtomically(set() / "images/shot3.exr",
                      ExrBytes({{"R", light, 2}, {"G", light, 1}, {"B", light, 0}}, ExrCompression::kZip));
  fs::remove(set() / "images/shot3.png");
  const LightField imported = Import(set(), scratch_ / "lf", {}).light_field;
  EXPECT_EQ(imported.views[0].master_path, "");
  const cv::Mat deep_master = ReadViewMaster(imported, imported.views[1]).pixels;
  ASSERT_EQ(deep_master.type(), CV_16UC3);
  EXPECT_EQ((deep_master.at<cv::Vec<std::uint16_t, 3>>(1, 1)[2]), 3001);
  EXPECT_NEAR(ReadViewMaster(imported, imported.views[2]).pixels.at<cv::Vec3f>(1, 1)[2], 3.5, 1e-2);
  for (const View& view : imported.views)
    EXPECT_EQ(ReadImageFile((scratch_ / "lf" / view.image_path).string()).type(), CV_8UC3) << view.image_path;
}

// As a replay takes them: what is floating point is light.
TEST_F(LlffSet, FloatsAreLinearLightInEveryFileKind) {
  const cv::Mat light(kHeight, kWidth, CV_32FC3, cv::Scalar(0.03, 0.2, 0.5));
  // OpenCV writes TIFFs of floating point as LogLuv unless it is told otherwise.
  for (const char* name : {"shot2.tif", "shot3.hdr"}) cv::imwrite((set() / "images" / name).string(), light);
  cv::imwrite((set() / "images/shot4.TIFF").string(), light, {cv::IMWRITE_TIFF_COMPRESSION, 1});
  for (const char* name : {"shot2.png", "shot3.png", "shot4.png"}) fs::remove(set() / "images" / name);
  const LightField imported = Import(set(), scratch_ / "lf", {}).light_field;
  for (const std::size_t i : {1UL, 2UL, 3UL}) {
    const View& view = imported.views[i];
    EXPECT_EQ(view.master_transfer, Transfer::kLinear) << view.master_path;
    EXPECT_NEAR(ReadViewMaster(imported, view).pixels.at<cv::Vec3f>(1, 1)[2], 0.5, 0.015);
    EXPECT_NEAR(ReadImageFile((scratch_ / "lf" / view.image_path).string()).at<cv::Vec3b>(1, 1)[2],
                255 * SrgbFromLinear(0.5F), 3);
  }
}

TEST_F(LlffSet, DamageIsRefusedByName) {
  const std::string whole = Npy(LlffRows(wall_));
  for (const std::size_t left : {0ul, 5ul, 9ul, 60ul, 128ul, 200ul, whole.size() - 8, whole.size() - 1}) {
    Write(whole.substr(0, left));
    ExpectRefused("copy it again");
  }
  Write(Npy(LlffRows(wall_), {}, "900000000, 17"));
  ExpectRefused("cut short");
  Write(Npy(LlffRows(wall_), {}, "5, 17, 1"));
  ExpectRefused("one or two dimensions");
  Write(Npy(LlffRows(wall_), {}, "11111111111"));  // more than 32 bits
  ExpectRefused("one or two dimensions");
  Write(Npy(LlffRows(wall_), {}, "900000000, 0"));
  ExpectRefused("without numbers");
  Write(Npy(LlffRows(wall_).leftCols(15)));
  ExpectRefused("a row of 17");
  Write(Npy(LlffRows(wall_), {"<i8", false, 1}));
  ExpectRefused("numbers of type '<i8'");
  for (const auto& [column, value, words] :
       std::initializer_list<std::tuple<int, double, const char*>>{{3, std::nan(""), "not finite"},
                                                                   {0, 3.0, "not a rotation"},
                                                                   {14, -60.0, "no camera's"},
                                                                   {15, 5.0, "no range"}}) {
    Eigen::MatrixXd rows = LlffRows(wall_);
    rows(2, column) = value;
    Write(Npy(rows));
    ExpectRefused(words);
    ExpectRefused("row 2 (shot3.png)");
  }
  Write(Npy(LlffRows(wall_).topRows(4)));
  ExpectRefused("4 poses");
  Write(whole);
  fs::remove_all(set() / "images");
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("with images")));
}

// ---- COLMAP ----

class ColmapSet : public testing::TestWithParam<bool> {
 protected:
  ColmapSet() : wall_(Wall()) {
    WritePhotographs(wall_, set() / "images");
    WriteModel(GetParam());
  }
  fs::path set() const { return scratch_ / "set"; }
  fs::path model() const { return set() / "sparse/0"; }
  std::string ending() const { return GetParam() ? ".bin" : ".txt"; }
  void WriteModel(bool binary) const {
    fs::create_directories(model());
    const ColmapReconstruction colmap = ToColmap(wall_);
    const ColmapFiles files = binary ? ToColmapBinary(colmap) : ToColmapText(colmap);
    const char* ending = binary ? ".bin" : ".txt";
    std::ofstream(model() / (std::string("cameras") + ending), std::ios::binary) << files.cameras;
    std::ofstream(model() / (std::string("images") + ending), std::ios::binary) << files.images;
    std::ofstream(model() / (std::string("points3D") + ending), std::ios::binary) << files.points3d;
  }
  LightField Read() const { return ReadPosedSet(set(), {}, {}).light_field; }
  ScratchFolder scratch_;
  LightField wall_;
};

TEST_P(ColmapSet, IsReadWithPointsAndTracks) {
  const LightField read = Read();
  ExpectSameCameras(read, wall_);
  ExpectPointsOnTheirObservations(read, wall_.points.size());
  EXPECT_THAT(read.doubts, IsEmpty());
  EXPECT_EQ(read.points[3].rgb, wall_.points[3].rgb);
  for (const fs::path& place : {model(), set() / "sparse", model() / ("images" + ending())})
    EXPECT_EQ(ReadPosedSet(place, {}, {}).light_field.views.size(), 5u) << place;
  const Imported imported = Import(set(), scratch_ / "lf", {});
  EXPECT_EQ(imported.subject_told_by, "the points");
  ExpectPointsOnTheirObservations(ReadLightField(scratch_ / "lf"), wall_.points.size());
  const double depth = (wall_.views[2].cam_from_world * imported.light_field.subject->center_in_world).z();
  EXPECT_GT(depth, kNear);
  EXPECT_LT(depth, kFar);
}

TEST_P(ColmapSet, TwoNamesOfOnePhotographAreRefused) {
  wall_.views[1].image_path = "images/left/shot1.png";
  wall_.views[2].image_path = "images/right/shot1.png";
  WriteModel(GetParam());
  EXPECT_THAT([&] { Read(); },
              ThrowsMessage<Error>(AllOf(HasSubstr("number 1 and 2, lead to the photograph 'shot1.png'"),
                                         HasSubstr("with images"))));
  for (const char* folder : {"left", "right"}) {
    fs::create_directories(set() / "images" / folder);
    fs::copy(set() / "images/shot1.png", set() / "images" / folder / "shot1.png");
  }
  EXPECT_EQ(Read().views.size(), 5u);
}

TEST_P(ColmapSet, OtherModelsBesideItAreNamed) {
  if (!GetParam())  // COLMAP's own text begins so
    WriteFileAtomically(model() / "images.txt",
                        "# Image list\n# Number of images: 5, mean observations: 8\n" +
                            ReadWholeFile(model() / "images.txt"));
  fs::create_directories(set() / "sparse/notes");
  EXPECT_THAT(Read().doubts, IsEmpty());
  fs::copy(model(), set() / "sparse/1");
  EXPECT_THAT(Read().doubts, ElementsAre(AllOf(HasSubstr("sparse/0 with 5 images; give"),
                                               HasSubstr((set() / "sparse/1").string() + " with 5 images"))));
  EXPECT_THAT(ReadPosedSet(set() / "sparse/1", {}, {}).light_field.doubts, IsEmpty())
      << "the one that was asked for";
  EXPECT_THAT(ReadPosedSet(model(), {}, {}).light_field.doubts, IsEmpty());
}

// What a set's files say must not make ulf write, or fetch photographs from, outside of the folders
// that it was given.
TEST_P(ColmapSet, NamesThatLeaveTheFolderAreNotFollowed) {
  ColmapReconstruction colmap = ToColmap(wall_);
  fs::copy_file(set() / "images/shot1.png", scratch_ / "outside.png");
  colmap.images[1].name = "../../outside.png";
  const ColmapFiles files = GetParam() ? ToColmapBinary(colmap) : ToColmapText(colmap);
  std::ofstream(model() / ("images" + ending()), std::ios::binary) << files.images;
  const auto outside = [&] {
    std::set<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(scratch_.path()))
      if (entry.path().string().find("/lf") == std::string::npos) found.insert(entry.path());
    return found;
  };
  const auto before = outside();
  const Imported imported = Import(set(), scratch_ / "lf", {});
  EXPECT_EQ(imported.light_field.views.size(), 4u);
  EXPECT_THAT(Read().doubts, Contains(HasSubstr("outside.png")));
  EXPECT_EQ(outside(), before);
}

TEST_P(ColmapSet, ResizedPhotographsMoveTheObservations) {
  fs::remove_all(set() / "images");
  WritePhotographs(wall_, set() / "images_2", {kWidth / 2, kHeight / 2});
  const LightField half = Read();
  EXPECT_THAT(half.doubts, ElementsAre(HasSubstr("resized")));
  ExpectPointsOnTheirObservations(half, wall_.points.size());
}

TEST_P(ColmapSet, TakesMasksAndNamesIncompletePhotographs) {
  fs::create_directories(set() / "masks");
  cv::Mat mask(kHeight, kWidth, CV_8U, cv::Scalar(255));
  mask.at<std::uint8_t>(3, 4) = 0;
  cv::imwrite((set() / "masks/shot2.png.png").string(), mask);
  cv::imwrite((set() / "images/extra.png").string(), mask);
  fs::remove(set() / "images/shot5.png");
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 4u);
  EXPECT_THAT(read.doubts, AllOf(Contains(AllOf(HasSubstr("left out"), HasSubstr("shot5.png"))),
                                 Contains(AllOf(HasSubstr("without a pose"), HasSubstr("extra.png")))));
  const LightField imported = Import(set(), scratch_ / "lf", {}).light_field;
  EXPECT_EQ(cv::countNonZero(ReadViewMask(imported, imported.views[1]) == 0), 1);
  for (const View& view : read.views) fs::remove(set() / "images" / view.image_path);
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("with images")));
}

TEST_P(ColmapSet, ACutFileIsRefusedByName) {
  for (const std::string name : {"cameras", "images", "points3D"}) {
    const fs::path file = model() / (name + ending());
    const std::string whole = ReadWholeFile(file);
    int read = 0;
    for (int part = 1; part < 8; ++part) {
      fs::resize_file(file, whole.size() * static_cast<std::size_t>(part) / 8);
      try {
        Read();
        ++read;
      } catch (const Error& error) {
        EXPECT_THAT(error.what(), AnyOf(HasSubstr(file.string()), HasSubstr("among the cameras"),
                                        HasSubstr("no images"), HasSubstr("no COLMAP model")))
            << name;
      }
      std::ofstream(file, std::ios::binary) << whole;
    }
    // Text that ends with a whole line looks complete; bytes do not.
    EXPECT_LE(read, GetParam() ? 0 : 7) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, ColmapSet, testing::Bool(),
                         [](const auto& binary) { return binary.param ? "Binary" : "Text"; });

class ColmapBinarySet : public ColmapSet {};
INSTANTIATE_TEST_SUITE_P(Format, ColmapBinarySet, testing::Values(true));

TEST_P(ColmapBinarySet, CountsThatLieAllocateNothing) {
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string whole = ReadWholeFile(model() / name);
    std::string lie = whole;
    lie[6] = '\x7f';  // of the eight bytes of the count
    std::ofstream(model() / name, std::ios::binary) << lie;
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(AllOf(HasSubstr(name), HasSubstr("cut short"))))
        << name;
    std::ofstream(model() / name, std::ios::binary) << whole;
  }
}

TEST_P(ColmapSet, WithoutItsImagesNamesTheMissingFile) {
  fs::remove(model() / ("images" + ending()));
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("images" + ending())));
}

TEST_P(ColmapBinarySet, BesideATextModelTheBinaryOneCounts) {
  wall_.views[0].cam_from_world.translation.x() += 1;
  WriteModel(false);
  const LightField read = Read();
  EXPECT_LT(read.views[0].cam_from_world.translation.x(), 0.5);
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("the binary one is read")));
}

// ---- which format it is ----

TEST(PosedSets, DuplicatesAreReportedAndCanBeChosen) {
  const ScratchFolder scratch;
  LightField wall = Wall(CameraModel::Pinhole(kWidth, kHeight, 60));
  WritePhotographs(wall, scratch / "images");
  std::ofstream(scratch / "poses_bounds.npy", std::ios::binary) << Npy(LlffRows(wall));
  fs::create_directories(scratch / "sparse/0");
  wall.views[0].cam_from_world.translation.x() += 1;
  const ColmapFiles files = ToColmapText(ToColmap(wall));
  std::ofstream(scratch / "sparse/0/cameras.txt") << files.cameras;
  std::ofstream(scratch / "sparse/0/images.txt") << files.images;
  EXPECT_THAT(FormatsIn(scratch.path()), ElementsAre(SetFormat::kColmap, SetFormat::kLlff));
  const PosedSet first = ReadPosedSet(scratch.path(), {}, {});
  EXPECT_EQ(first.format, "COLMAP, text");
  EXPECT_THAT(first.light_field.doubts, ElementsAre(HasSubstr("(format llff)")));
  EXPECT_EQ(ReadPosedSet(scratch.path(), SetFormat::kLlff, {}).format, "LLFF");
  EXPECT_THAT([&] { ReadPosedSet(scratch.path(), SetFormat::kBundler, {}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("bundler"), HasSubstr("colmap"))));
  EXPECT_THROW(SetFormatFromName("nerf"), Refusal);
  for (const char* name : {"colmap", "llff", "nerf-synthetic", "realityscan"})
    EXPECT_STREQ(Name(*SetFormatFromName(name)), name);
}

TEST(PosedSets, CountsFilesBesideThePhotographs) {
  const ScratchFolder scratch;
  const fs::path images = scratch / "set/images";
  fs::create_directories(images);
  json frames = json::array();
  fs::create_directories(images / "left");
  fs::create_directories(images / "masks");
  for (int i = 0; i < 3; ++i) {
    const std::string name = fmt::format("images/{}shot{}.png", i == 2 ? "left/" : "", i),
                      mask = fmt::format("images/masks/shot{}.png", i);
    cv::imwrite((scratch / "set" / name).string(), cv::Mat(48, 64, CV_8UC3, cv::Scalar(9, 99, 199)));
    cv::imwrite((scratch / "set" / mask).string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(255)));
    frames.push_back({{"file_path", name},
                      {"mask_path", mask},
                      {"transform_matrix", {{1, 0, 0, 0.1 * i}, {0, 1, 0, 0}, {0, 0, 1, 2}, {0, 0, 0, 1}}}});
  }
  std::ofstream(scratch / "set/transforms.json")
      << json{{"fl_x", 60}, {"w", 64}, {"h", 48}, {"frames", frames}};
  std::ostringstream said;
  const auto logger = spdlog::default_logger();
  const auto import = [&](const char* name) {
    said.str("");
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
    Import(scratch / "set", scratch / name, {.subject = Subject{Eigen::Vector3d::Zero(), 0.3}});
    spdlog::set_default_logger(logger);
    return said.str();
  };
  for (const char* map : {"shot0_depth_0001.png", "shot1_normal.png"})
    fs::copy_file(images / "shot1.png", images / map);
  EXPECT_THAT(import("alone"), testing::Not(HasSubstr("left out")));
  fs::copy_file(images / "shot1.png", images / "zero.png");
  fs::copy_file(images / "shot1.png", images / "copy");
  for (const char* beside : {"notes.txt", "model.nvm", "cameras.sfm", "photographs.lst"})
    std::ofstream(images / beside) << "words\n";
  fs::create_directories(images / "more");
  fs::copy_file(images / "shot1.png", images / "more/shot9.png");
  const std::string words = import("beside");
  EXPECT_THAT(words, HasSubstr("1 folder inside holds pictures (more)"));
  EXPECT_THAT(words, HasSubstr("left out: 1 photograph without a pose (zero.png)"));
  EXPECT_THAT(words, AllOf(HasSubstr("a picture by the first bytes"), HasSubstr("(copy)")));
  EXPECT_THAT(words, testing::Not(testing::ContainsRegex("notes|model|cameras|lst")));
}

TEST(PosedSets, WithoutPosesTheWayOutIsSaid) {
  const ScratchFolder scratch;
  EXPECT_THAT([&] { ReadPosedSet(scratch.path(), {}, {}); },
              ThrowsMessage<Error>(HasSubstr("the folder is empty")));
  std::ofstream(scratch / "notes.md") << "x";
  EXPECT_THAT([&] { ReadPosedSet(scratch.path(), {}, {}); },
              ThrowsMessage<Error>(HasSubstr("docs/exchange.md")));
  EXPECT_THAT([&] { ReadPosedSet(scratch / "none", {}, {}); }, ThrowsMessage<Error>(HasSubstr("no such")));
  cv::imwrite((scratch / "a.png").string(), cv::Mat(2, 2, CV_8UC3, cv::Scalar(1, 2, 3)));
  EXPECT_THAT([&] { ReadPosedSet(scratch.path(), {}, {}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("without poses"), HasSubstr("replay:"))));
  std::ofstream(scratch / "video.mp4") << "x";
  EXPECT_THAT([&] { ReadPosedSet(scratch / "video.mp4", {}, {}); },
              ThrowsMessage<Error>(HasSubstr("replay:")));
}

TEST(SubjectOfSet, AxesThatMeetWhereNothingIsDoNotCount) {
  // Cameras that toe in to a point far before the wall.
  LightField wall = Wall(CameraModel::Pinhole(kWidth, kHeight, 60));
  PosedSet set;
  set.light_field = wall;
  for (std::size_t i = 0; i < wall.views.size(); ++i)
    set.light_field.views[i].cam_from_world =
        LookAt({0.3 * static_cast<double>(i) - 0.6, 0, 0}, {0, 0, 0.6}, {0, -1, 0});
  set.light_field.points.clear();
  EXPECT_EQ(FindSubject(set)->told_by, "the optical axes");
  set.depth_bounds.assign(wall.views.size(), {kNear, kFar});
  ASSERT_TRUE(FindSubject(set));
  EXPECT_EQ(FindSubject(set)->told_by, "the depth bounds");
}

TEST(SubjectOfSet, IgnoresPointsOfOtherPoses) {
  const ScratchFolder scratch;
  PosedSet set;
  set.light_field = test::TrackedLightField(scratch / "lf", {test::Straight()});
  const auto right = FindSubject(set);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->told_by, "the optical axes");
  for (ScenePoint& point : set.light_field.points) point.position_in_world *= 1000;
  const auto found = FindSubject(set);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->told_by, "the optical axes");
  EXPECT_EQ(found->subject, right->subject);
}

TEST(PosedSets, TakesInAForwardFacingSetWithoutSubject) {
  ULF_NEED_TEST_DATA(fern, "llff_fern");
  const ScratchFolder scratch;
  const Imported imported = Import(fern, scratch / "lf", {});
  EXPECT_EQ(imported.light_field.views.size(), 20u);
  EXPECT_EQ(imported.light_field.cameras.at(0).width, 1008);
  EXPECT_NEAR(imported.light_field.cameras.at(0).fx, 3260.5 / 4, 0.1);
  for (const View& view : imported.light_field.views) {
    const auto img = imported.light_field.CameraOf(view).ImgFromCam(
        view.cam_from_world * imported.light_field.subject->center_in_world);
    EXPECT_TRUE(img && imported.light_field.CameraOf(view).Contains(*img)) << view.image_path;
  }
}

}  // namespace
}  // namespace ulf::posed_sets_test
