// Tests: core/light_field/formats/transforms_json, core/light_field/formats/transforms_camera,
// core/light_field/formats/frame_files, core/light_field/formats/posed_set, core/geometry/camera_fit,
// core/light_field/exchange/readers/nerf_synthetic_set, core/light_field/folder/view_images.
//
// Sets as strangers bring them: lenses spelt otherwise, matrices that are rounded or scaled, photographs that
// lie elsewhere or nowhere. Each is read right or named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/camera_fit.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/test_paths.h"

namespace ulf::set_tolerance_test {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using nlohmann::json;
using test::ScratchFolder;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

// Five frames of images/shot_N.png with a pinhole of 60 px.
class StrangersSet : public testing::Test {
 protected:
  StrangersSet() {
    document_ = {{"fl_x", 60.0}, {"fl_y", 60.0}, {"cx", 32.0}, {"cy", 24.0}, {"w", kWidth}, {"h", kHeight}};
    fs::create_directories(set() / "images");
    for (int i = 0; i < 5; ++i) {
      const std::string name = fmt::format("images/shot_{}.png", i);
      cv::imwrite((set() / name).string(), NoiseFrame(i).image.pixels);
      document_["frames"].push_back({{"file_path", name}});
      Pose(i, WorldFromCam(i));
    }
  }

  fs::path set() const { return scratch_ / "set"; }
  static Matrix4d WorldFromCam(int i) {
    return ViewNumber(i).cam_from_world.Inverse().Matrix() * Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
  }
  void Pose(int i, const Matrix4d& matrix, const char* key = "transform_matrix") {
    json rows = json::array();
    for (int r = 0; r < 4; ++r) rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)});
    document_["frames"][static_cast<std::size_t>(i)][key] = rows;
  }
  LightField Read() {
    std::ofstream(set() / "transforms.json") << JsonText(document_);
    return ReadPosedSet(set(), {}, {}).light_field;
  }
  CameraModel Camera() { return Read().cameras.at(0); }
  void ExpectRefused(const std::string& first, const std::string& second) {
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(AllOf(HasSubstr("transforms.json"), HasSubstr(first),
                                                            HasSubstr(second))));
  }
  void ExpectPoses(const LightField& read, double tolerance) {
    ASSERT_EQ(read.views.size(), 5u);
    for (int i = 0; i < 5; ++i)
      EXPECT_LT((read.views[static_cast<std::size_t>(i)].cam_from_world.Matrix() -
                 ViewNumber(i).cam_from_world.Matrix())
                    .norm(),
                tolerance)
          << i;
  }

  ScratchFolder scratch_;
  json document_;
};

// ---- Lenses ----

// Worked out by hand from OpenCV's formula for the ray (0.2, -0.1, 1), r² = 0.05.
TEST_F(StrangersSet, DistortionParamsBendTheLens) {
  document_["distortion_params"] = {-0.3, 0.1, 0, 0, 0.01, 0.02};
  const Vector2d img = *Camera().ImgFromCam({0.2, -0.1, 1});
  EXPECT_NEAR(img.x(), 32 + 60 * (0.2 * 0.98525 + 0.0022), 1e-9);
  EXPECT_NEAR(img.y(), 24 + 60 * (-0.1 * 0.98525 - 0.0001), 1e-9);
  // A frame's own override those of the set, however either is spelt.
  document_["frames"][0]["k1"] = 0.05;
  EXPECT_EQ(Read().cameras.at(0).coefficients, (std::array<double, 5>{0.05, 0, 0, 0, 0}));
  document_["frames"][0].erase("k1");
  document_.erase("distortion_params");
  document_["k1"] = 0.2;
  document_["frames"][0]["distortion_params"] = {0, 0.1, 0, 0, 0, 0};
  EXPECT_EQ(Read().cameras.at(0).coefficients, (std::array<double, 5>{0, 0.1, 0, 0, 0}));
}

TEST_F(StrangersSet, DistortionParamsMustBeSixAndAgree) {
  document_["distortion_params"] = {-0.3, 0.1, 0, 0};
  ExpectRefused("'distortion_params' is [-0.3", "six numbers");
  document_["distortion_params"] = "none";
  ExpectRefused("'distortion_params' is \"none\"", "six numbers");
  document_["distortion_params"] = {-0.3, 0.1, 0, 0, 0, 0};
  document_["k1"] = -0.2;
  ExpectRefused("'distortion_params'", "contradict");
  document_["distortion_params"] = {-0.2, 0, 0, 0, 0, 0};
  EXPECT_EQ(Camera().coefficients[0], -0.2);
}

// RealityCapture's k4 comes through nerfstudio. At the corner r² is 0.444, and k4 moves the ray by 0.5 px.
TEST_F(StrangersSet, AFourthRadialCoefficientIsFitted) {
  for (const char* spelt : {"distortion_params", "k4"}) {
    const json before = document_;
    if (spelt == std::string("k4"))
      document_.update({{"k1", -0.1}, {"k4", 0.3}, {"p1", 0.002}});
    else
      document_["distortion_params"] = {-0.1, 0, 0, 0.3, 0.002, 0};
    const LightField read = Read();
    for (const double x : {-0.5, 0.0, 0.45})
      for (const double y : {-0.35, 0.1, 0.38}) {
        const double r2 = x * x + y * y, radial = 1 - 0.1 * r2 + 0.3 * std::pow(r2, 4);
        const Vector2d truth(32 + 60 * (x * radial + 2 * 0.002 * x * y),
                             24 + 60 * (y * radial + 0.002 * (r2 + 2 * y * y)));
        EXPECT_LT((*read.cameras.at(0).ImgFromCam({x, y, 1}) - truth).norm(), 0.1) << x << ' ' << y;
      }
    EXPECT_THAT(read.doubts, testing::Each(HasSubstr("a lens with k4 is taken into our model for 1 camera")));
    document_ = before;
  }
}

TEST_F(StrangersSet, FieldsOfViewAreFocalLengths) {
  const auto focal = [&](const json& keys) {
    const json before = document_;
    for (const char* key : {"fl_x", "fl_y", "x_fov", "y_fov", "camera_angle_x", "camera_angle_y"})
      document_.erase(key);
    document_.update(keys);
    const CameraModel camera = Camera();
    document_ = before;
    return Vector2d(camera.fx, camera.fy);
  };
  // Half of 64 pixels at 45 degrees; half of 48 pixels at 30 degrees.
  const double tall = 24 / std::tan(std::numbers::pi / 6);
  EXPECT_LT((focal({{"x_fov", 90}}) - Vector2d(32, 32)).norm(), 1e-9);
  EXPECT_LT((focal({{"x_fov", 90}, {"y_fov", 60}}) - Vector2d(32, tall)).norm(), 1e-9);
  EXPECT_LT((focal({{"y_fov", 60}}) - Vector2d(tall, tall)).norm(), 1e-9);
  EXPECT_LT((focal({{"camera_angle_y", std::numbers::pi / 3}}) - Vector2d(tall, tall)).norm(), 1e-9);
  EXPECT_LT((focal({{"fovx", 90}, {"fovy", std::numbers::pi / 3}}) - Vector2d(32, tall)).norm(), 1e-9);
  EXPECT_LT((focal({{"fl_y", 70}}) - Vector2d(70, 70)).norm(), 1e-9);
  EXPECT_LT((focal({{"fl_x", 32}, {"camera_angle_x", 1.5708}}) - Vector2d(32, 32)).norm(), 1e-9);
  const json before = document_;
  document_["x_fov"] = 180;
  ExpectRefused("'x_fov' is 180", "between 0 and 180");
  document_ = before;
  document_["camera_angle_x"] = 90;
  ExpectRefused("'camera_angle_x' is 90", "between 0 and 180");
  document_ = before;
  document_["x_fov"] = 90;  // beside 60 px
  ExpectRefused("'fl_x' says a focal length of 60 px", "'x_fov' one of 32 px");
  document_ = before;
  document_["frames"][1]["fovx"] = std::numbers::pi / 2;  // a frame's own goes before the set's
  EXPECT_NEAR(Read().cameras.at(1).fx, 32, 1e-9);
}

TEST_F(StrangersSet, OtherLensesAreRefusedByName) {
  const json before = document_;
  document_.update({{"camera_model", "FULL_OPENCV"}, {"k4", 0.01}});
  ExpectRefused("FULL_OPENCV divides", "undistort");
  document_ = before;
  for (const char* key : {"ftheta_p0", "ftheta_p4", "latlong", "equirectangular", "orthographic", "k5", "k6",
                          "s1", "s2", "s3", "s4"}) {
    for (const bool of_frame : {false, true}) {
      (of_frame ? document_["frames"][0] : document_)[key] = 0.1;
      ExpectRefused(fmt::format("'{}' belongs to", key), "undistort");
      document_ = before;
    }
    document_[key] = false;
    EXPECT_THAT(Read().doubts, IsEmpty()) << key;
    document_ = before;
  }
  for (const char* model : {"EQUIRECTANGULAR", "ORTHOPHOTO", "VR180_L", "OMNIDIRECTIONALSTEREO_R",
                            "FISHEYE624", "THIN_PRISM_FISHEYE", "FOV", "new"}) {
    document_["camera_model"] = model;
    ExpectRefused(fmt::format("camera model '{}' is not supported", model), "PINHOLE");
  }
  for (const char* model : {"OPENCV_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE"}) {
    document_["camera_model"] = model;
    EXPECT_EQ(Camera().distortion, Distortion::kFisheye) << model;
  }
}

// Programs and people write the same in many ways.
TEST_F(StrangersSet, OtherSpellingsMeanTheSame) {
  const json before = document_;
  for (const auto& [key, other] : std::initializer_list<std::pair<const char*, const char*>>{
           {"fl_x", "fx"}, {"fl_y", "fy"}, {"w", "width"}, {"h", "height"}}) {
    document_[other] = document_[key];
    document_.erase(key);
  }
  EXPECT_THAT(Read().doubts, IsEmpty());
  EXPECT_EQ(Camera().fx, 60);
  document_["width"] = 2 * kWidth;  // of which the photographs are reduced copies
  document_["height"] = 2 * kHeight;
  EXPECT_EQ(Camera().fx, 30);
  document_ = before;
  document_["camera_model"] = "opencv_fisheye";
  EXPECT_EQ(Camera().distortion, Distortion::kFisheye);
  document_["camera_model"] = "FISHEYE";  // COLMAP's of 2026
  EXPECT_EQ(Camera().distortion, Distortion::kFisheye);
  document_.erase("camera_model");
  for (const json& yes : {json(true), json(1)}) {
    document_["is_fisheye"] = yes;
    EXPECT_EQ(Camera().distortion, Distortion::kFisheye) << yes;
  }
  document_["is_fisheye"] = "yes";
  ExpectRefused("'is_fisheye' is \"yes\"", "true or false");
}

// As nerfstudio has it, where every frame has its own length along one axis.
TEST_F(StrangersSet, FramesAddTheFocalLengthTheSetLacks) {
  document_.erase("fl_x");
  document_["fl_y"] = 70;
  for (json& frame : document_["frames"]) frame["fl_x"] = 65;
  EXPECT_EQ(Camera().fx, 65);
  EXPECT_EQ(Camera().fy, 70);
  document_["fl_x"] = 60;  // replaced by the frames', and the other with it
  EXPECT_EQ(Camera().fy, 65);
}

// NeuS2 has them in frames.
TEST_F(StrangersSet, MatricesOfACameraAreRead) {
  for (const char* key : {"fl_x", "fl_y", "cx", "cy"}) document_.erase(key);
  for (const char* key : {"intrinsic_matrix", "camera_matrix", "K"}) {
    for (json& frame : document_["frames"]) frame[key] = {{61, 0, 31}, {0, 62, 23}, {0, 0, 1}};
    const LightField read = Read();
    EXPECT_THAT(read.doubts, IsEmpty());
    const CameraModel& camera = read.cameras.at(0);
    EXPECT_EQ(Vector2d(camera.fx, camera.fy), Vector2d(61, 62)) << key;
    EXPECT_EQ(Vector2d(camera.cx, camera.cy), Vector2d(31, 23)) << key;
    for (json& frame : document_["frames"]) frame.erase(key);
  }
  document_["fl_x"] = 60;
  document_["K"] = {{120, 0, 31}, {0, 120, 23}, {0, 0, 1}};
  ExpectRefused("'K' says a focal length of 120 px", "one of 60 px");
  document_["K"] = "none";
  ExpectRefused("'K' must be a camera's matrix", "fx 0 cx");
}

// The keys that nerfstudio's and instant-ngp's loaders look for, and nothing else, pass in silence.
TEST_F(StrangersSet, KnowsTheKeysOfTheFormats) {
  for (const char* key : {"aabb_scale",
                          "scale",
                          "offset",
                          "up",
                          "enable_depth_loading",
                          "n_extra_learnable_dims",
                          "render_aabb",
                          "train_filenames",
                          "val_filenames",
                          "test_filenames",
                          "orientation_override",
                          "auto_scale_poses_override",
                          "applied_transform",
                          "applied_scale",
                          "aabb",
                          "sharpen",
                          "importance_sampling",
                          "enable_ray_loading",
                          "integer_depth_scale",
                          "sharpness_discard_threshold"})
    document_[key] = 1;
  for (const char* key : {"sharpness", "colmap_im_id", "rotation"}) document_["frames"][1][key] = 1;
  EXPECT_THAT(Read().doubts, IsEmpty());
  for (const char* key : {"white_transparent", "black_transparent", "fix_premult", "n_frames", "envmap"}) {
    document_[key] = 1;
    EXPECT_THAT(Read().doubts, ElementsAre(HasSubstr(fmt::format("'{}' is not used", key))));
    document_.erase(key);
  }
}

// Instant-ngp's loader lets comments pass.
TEST_F(StrangersSet, WhatNobodyReadsMayBeNoNumber) {
  for (json& frame : document_["frames"]) frame["sharpness"] = "here";
  std::string text = JsonText(document_);
  for (std::size_t at = 0; (at = text.find("\"here\"", at)) != std::string::npos;) text.replace(at, 6, "NaN");
  std::ofstream(set() / "transforms.json") << text;
  ExpectPoses(ReadPosedSet(set(), {}, {}).light_field, 1e-9);
}

TEST_F(StrangersSet, CommentsArePassedOver) {
  std::ofstream(set() / "transforms.json") << "// by hand\n"
                                           << JsonText(document_).insert(1, " /* 60 mm */ ") << "\n// end\n";
  EXPECT_EQ(ReadPosedSet(set(), {}, {}).light_field.views.size(), 5u);
}

// ---- Matrices ----

// NeuS2's camera axes are OpenCV's, Mitsuba's are x left, y up, z forward.
TEST_F(StrangersSet, CameraAxesOfOtherLoadersAreTurned) {
  const auto pose_with = [&](double x, double y, double z) {
    for (int i = 0; i < 5; ++i)
      Pose(i, ViewNumber(i).cam_from_world.Inverse().Matrix() * Eigen::Vector4d(x, y, z, 1).asDiagonal());
  };
  document_["from_na"] = true;
  pose_with(1, 1, 1);
  ExpectPoses(Read(), 1e-9);
  document_["from_na"] = false;
  pose_with(1, -1, -1);
  ExpectPoses(Read(), 1e-9);
  document_["normal_mts_args"] = json::array();
  pose_with(-1, -1, 1);
  ExpectPoses(Read(), 1e-9);
  EXPECT_THAT(Read().doubts, IsEmpty());
}

TEST_F(StrangersSet, AScaleIsTakenOutOfTheMatrix) {
  for (int i = 0; i < 5; ++i) {
    Matrix4d scaled = WorldFromCam(i);
    scaled.topLeftCorner<3, 3>() *= 1.37;
    Pose(i, scaled);
  }
  const LightField read = Read();
  ExpectPoses(read, 1e-9);
  EXPECT_THAT(read.doubts, ElementsAre(AllOf(HasSubstr("5 poses"), HasSubstr("a scale of 1.37"))));
}

TEST_F(StrangersSet, FewDecimalsAreMadeRotations) {
  for (const double decimals : {100.0, 1000.0}) {
    for (int i = 0; i < 5; ++i) {
      Matrix4d rounded = WorldFromCam(i);
      for (Eigen::Index k = 0; k < 16; ++k)
        if (k % 4 != 3 && k < 12) rounded(k) = std::round(rounded(k) * decimals) / decimals;
      Pose(i, rounded);
    }
    const LightField read = Read();
    ExpectPoses(read, 5 / decimals);
    for (const View& view : read.views) {
      const Eigen::Matrix3d rotation = view.cam_from_world.RotationMatrix();
      EXPECT_LT((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    }
    EXPECT_THAT(read.doubts, ElementsAre(AllOf(HasSubstr("not rotations"), HasSubstr("degrees"))));
  }
}

TEST_F(StrangersSet, SinglePrecisionIsNoFault) {
  for (int i = 0; i < 5; ++i) {
    Matrix4d single = WorldFromCam(i).cast<float>().cast<double>();
    single.row(3) << 1e-8, -2e-8, 0, 1 + 1e-7;
    Pose(i, single);
  }
  const LightField read = Read();
  ExpectPoses(read, 1e-5);
  EXPECT_THAT(read.doubts, IsEmpty());
  Matrix4d other = WorldFromCam(2);
  other(3, 3) = 2;
  Pose(2, other);
  ExpectRefused("frame 2", "the last row of 'transform_matrix' must be 0 0 0 1");
}

TEST_F(StrangersSet, MirroredAndSkewedMatricesAreRefused) {
  Matrix4d matrix = WorldFromCam(1);
  matrix.col(0) *= -1;
  Pose(1, matrix);
  ExpectRefused("frame 1", "mirrored");
  matrix = WorldFromCam(1);
  matrix.block<3, 1>(0, 0) *= 1.1;
  Pose(1, matrix);
  ExpectRefused("frame 1", "differ in length");
  matrix.topLeftCorner<3, 3>().setZero();
  Pose(1, matrix);
  ExpectRefused("frame 1", "zero");
}

// Instant-ngp's rolling shutter: t = A + B u + C v + D; here 0.2 + 0.4 of the way in the middle row.
TEST_F(StrangersSet, AMovingCameraHasItsMiddlePose) {
  Matrix4d start = Matrix4d::Identity(), end = Matrix4d::Identity();
  end.topLeftCorner<3, 3>() = Eigen::AngleAxisd(0.1, Vector3d::UnitY()).toRotationMatrix();
  end(0, 3) = 1;
  Pose(0, start, "transform_matrix_start");
  Pose(0, end, "transform_matrix_end");
  document_["frames"][0].erase("transform_matrix");
  document_["rolling_shutter"] = {0.2, 0, 0.8};
  const LightField read = Read();
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("1 frame that moved meanwhile")));
  const Rigid3 world_from_cam = read.views[0].cam_from_world.Inverse();
  EXPECT_NEAR(world_from_cam.translation.x(), 0.6, 1e-9);
  const Vector3d forward = world_from_cam.rotation * Vector3d::UnitZ();
  EXPECT_NEAR(std::atan2(-forward.x(), -forward.z()), 0.06, 1e-9) << "OpenGL's cameras look back along z";
  document_["rolling_shutter"] = {0.2, 0};
  ExpectRefused("'rolling_shutter'", "three or four numbers");
}

// ---- Photographs ----

TEST_F(StrangersSet, MissingPhotographsAreLeftOut) {
  fs::remove(set() / "images/shot_1.png");
  fs::remove(set() / "images/shot_3.png");
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 3u);
  EXPECT_EQ(read.views[1].image_path, "images/shot_2.png");
  EXPECT_THAT(read.doubts, ElementsAre(AllOf(HasSubstr("2 photographs missing"), HasSubstr("shot_1.png"))));
  EXPECT_EQ(ReadTransformsJson(set() / "transforms.json").views.size(), 3u) << "without importing, too";
  fs::remove(set() / "images/shot_0.png");
  ExpectRefused("'images/shot_0.png' and 2 more are missing", "restore");
}

TEST_F(StrangersSet, PosesForTestingNeedNoPhotographs) {
  fs::rename(set() / "images", set() / "train");
  json test = {{"camera_angle_x", 0.9}, {"frames", json::array()}};
  for (std::size_t i = 0; i < 5; ++i) {
    json& frame = document_["frames"][i];
    frame["file_path"] = fmt::format("train/shot_{}.png", i);
    if (i > 0)
      test["frames"].push_back(frame), test["frames"].back()["file_path"] = fmt::format("test/{}", i);
  }
  std::ofstream(set() / "transforms_train.json") << JsonText(document_);
  std::ofstream(set() / "transforms_test.json") << JsonText(test);
  const LightField read = ReadPosedSet(set(), {}, {}).light_field;
  EXPECT_EQ(read.views.size(), 5u);
  EXPECT_THAT(read.doubts,
              testing::Contains(AllOf(HasSubstr("transforms_test.json"), HasSubstr("4 frames"))));
  // One of them was rendered.
  fs::create_directories(set() / "test");
  fs::copy(set() / "train/shot_2.png", set() / "test/2.png");
  const LightField more = ReadPosedSet(set(), {}, {}).light_field;
  EXPECT_EQ(more.views.size(), 6u);
  EXPECT_THAT(more.doubts, testing::Contains(HasSubstr("3 frames without their photographs left out")));
  fs::remove_all(set() / "train");
  EXPECT_THAT([&] { ReadPosedSet(set(), {}, {}); }, ThrowsMessage<Error>(HasSubstr("missing")));
}

// BlenderNeRF numbers the frames of both parts from 1, and other parts may be empty.
TEST_F(StrangersSet, PosesForTestingMayBearNamesOfTraining) {
  fs::rename(set() / "images", set() / "train");
  json test = document_;
  for (std::size_t i = 0; i < 5; ++i) {
    document_["frames"][i]["file_path"] = fmt::format("./train/shot_{}", i);
    test["frames"][i]["file_path"] = fmt::format("./test/shot_{}", i);
    test["frames"][i]["transform_matrix"][0][3] = 7 + i;
  }
  std::ofstream(set() / "transforms_train.json") << JsonText(document_);
  std::ofstream(set() / "transforms_test.json") << JsonText(test);
  test["frames"] = json::array();
  std::ofstream(set() / "transforms_val.json") << JsonText(test);
  const LightField read = ReadPosedSet(set(), {}, {}).light_field;
  ExpectPoses(read, 1e-9);
  EXPECT_THAT(read.doubts, ElementsAre(AllOf(HasSubstr("transforms_test.json"), HasSubstr("5 frames"))));
}

TEST_F(StrangersSet, AMissingPhotographIsNotItsNamesake) {
  for (const char* folder : {"left", "right"}) fs::create_directories(set() / "images" / folder);
  for (std::size_t i = 0; i < 5; ++i) {
    const std::string name = fmt::format("images/{}/{}.png", i < 2 ? "left" : "right", i < 2 ? i : i - 2);
    fs::rename(set() / fmt::format("images/shot_{}.png", i), set() / name);
    document_["frames"][i]["file_path"] = name;
  }
  ExpectPoses(Read(), 1e-9);
  fs::remove(set() / "images/left/1.png");
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 4u);
  EXPECT_EQ(read.views[2].image_path, "images/right/1.png");
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("1 photograph missing")));
}

TEST_F(StrangersSet, AMissingMaskIsNotThePhotograph) {
  for (const bool in_root : {false, true}) {
    for (std::size_t i = 0; i < 5; ++i) {
      json& frame = document_["frames"][i];
      frame["mask_path"] = fmt::format("masks/shot_{}.png", i);
      if (!in_root) continue;
      fs::rename(set() / frame["file_path"], set() / fmt::format("shot_{}.png", i));
      frame["file_path"] = fmt::format("shot_{}.png", i);
    }
    ExpectRefused("'masks/shot_0.png' is missing", "restore");
  }
}

class WayToAPhotograph : public StrangersSet, public testing::WithParamInterface<const char*> {};

TEST_P(WayToAPhotograph, IsFoundWhenImported) {
  for (std::size_t i = 0; i < 5; ++i)
    document_["frames"][i]["file_path"] =
        fmt::format(fmt::runtime(GetParam()), fmt::arg("i", i), fmt::arg("here", set().string()));
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_EQ(cv::norm(cv::imread((read.root / read.views[i].image_path).string()),
                       NoiseFrame(static_cast<int>(i)).image.pixels, cv::NORM_INF),
              0)
        << read.views[i].image_path;
  EXPECT_EQ(Import(set(), scratch_ / "lf", {.subject = Subject{{0, 0, 3}, 0.4}}).light_field.views.size(),
            5u);
}

INSTANTIATE_TEST_SUITE_P(Spelt, WayToAPhotograph,
                         testing::Values("images/shot_{i}.PNG", "images/shot_{i}.jpg", "IMAGES/SHOT_{i}.png",
                                         "shot_{i}.png", "images/shot_{i}", "../set/images/shot_{i}.png",
                                         "../../elsewhere/images/shot_{i}.png", "{here}/images/shot_{i}.png",
                                         "/data/fox/images/shot_{i}.png", "C:\\shoot\\images\\shot_{i}.png",
                                         "C:\\shoot\\raw\\shot_{i}.png"));

TEST_F(StrangersSet, PhotographsMayLieBesideItsFolder) {
  fs::rename(set() / "images", scratch_ / "images");
  for (std::size_t i = 0; i < 5; ++i)
    document_["frames"][i]["file_path"] = fmt::format("../set/images/shot_{}.png", i);
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 5u);
  EXPECT_TRUE(fs::equivalent(read.root / read.views[0].image_path, scratch_ / "images/shot_0.png"));
  // A set that is used in place must hold its photographs.
  for (std::size_t i = 0; i < 5; ++i)
    document_["frames"][i]["file_path"] = fmt::format("../images/shot_{}.png", i);
  EXPECT_EQ(Read().views.size(), 5u);
  EXPECT_THAT([&] { ReadTransformsJson(set() / "transforms.json"); },
              ThrowsMessage<Error>(HasSubstr("leaves the folder")));
}

TEST_F(StrangersSet, PhotographsMayLieInFoldersBelow) {
  fs::create_directories(set() / "images/card1");
  fs::create_directories(set() / "images/card2");
  for (int i = 0; i < 5; ++i) {
    const std::string name = fmt::format("shot_{}.png", i);
    fs::rename(set() / "images" / name, set() / "images" / (i < 3 ? "card1" : "card2") / name);
  }
  const LightField read = Read();
  ASSERT_EQ(read.views.size(), 5u);
  EXPECT_EQ(read.views[4].image_path, "images/card2/shot_4.png");
  // Smaller copies, masks and maps under the same name do not count.
  for (const char* folder : {"images_2/card1", "depths"}) fs::create_directories(set() / folder);
  fs::copy(set() / "images/card1", set() / "images_2/card1", fs::copy_options::recursive);
  fs::copy(set() / "images/card1", set() / "depths", fs::copy_options::recursive);
  EXPECT_EQ(Read().views[0].image_path, "images/card1/shot_0.png");
  fs::copy(set() / "images/card1/shot_0.png", set() / "images/card2/shot_0.png");
  ExpectRefused("both images/card1/shot_0.png and images/card2/shot_0.png", "'images/shot_0.png'");
}

// Instant-ngp marks what is not to be used, in any colour.
TEST_F(StrangersSet, OneHundredMegapixelsAreTaken) {
  const cv::Mat large(8400, 12000, CV_8UC1, cv::Scalar(90));
  cv::imwrite((set() / "images/shot_0.jpg").string(), large);
  fs::remove(set() / "images/shot_0.png");
  document_["frames"][0].update({{"file_path", "images/shot_0.jpg"},
                                 {"w", 12000},
                                 {"h", 8400},
                                 {"fl_x", 11000},
                                 {"fl_y", 11000},
                                 {"cx", 6000},
                                 {"cy", 4200}});
  Read();
  const LightField taken = Import(set(), scratch_ / "lf", {}).light_field;
  ExpectPoses(taken, 1e-9);
  const CameraModel& camera = taken.CameraOf(taken.views.at(0));
  EXPECT_EQ(camera.width, 12000);
  EXPECT_EQ(camera.fx, 11000);
  EXPECT_EQ(ReadWholeFile(scratch_ / "lf" / taken.views[0].image_path),
            ReadWholeFile(set() / "images/shot_0.jpg"));
}

TEST_F(StrangersSet, DynamicMasksExcludeWhatTheyMark) {
  cv::Mat mask(kHeight, kWidth, CV_8UC3, cv::Scalar::all(0));
  mask(cv::Rect(0, 0, kWidth, 12)) = cv::Scalar(0, 0, 1);
  cv::imwrite((set() / "images/dynamic_mask_shot_1.png").string(), mask);
  const LightField read = Read();
  const cv::Mat used = ReadViewMask(read, read.views[1]);
  ASSERT_FALSE(used.empty());
  EXPECT_EQ(cv::countNonZero(used), kWidth * (kHeight - 12));
  EXPECT_EQ(used.at<std::uint8_t>(11, 5), 0);
  EXPECT_TRUE(ReadViewMask(read, read.views[0]).empty());
  const LightField made = Import(set(), scratch_ / "lf", {.subject = Subject{{0, 0, 3}, 0.4}}).light_field;
  EXPECT_EQ(cv::norm(ReadViewMask(made, made.views[1]), used, cv::NORM_INF), 0);
}

// ---- Refusals ----

// Runs an import that fails, and returns what it warned of before.
template <typename Work>
std::string SaidBeforeFailing(const Work& work) {
  std::ostringstream said;
  const auto logger = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  EXPECT_ANY_THROW(work());
  spdlog::set_default_logger(logger);
  return said.str();
}

TEST_F(StrangersSet, RefusalsComeAfterTheirWarnings) {
  document_["sky_color"] = "blue";
  for (int i = 0; i < 5; ++i) {  // side by side, so that no subject is found
    Matrix4d matrix = Matrix4d::Identity();
    matrix(0, 3) = i;
    Pose(i, matrix);
  }
  Read();
  EXPECT_THAT(SaidBeforeFailing([&] { Import(set(), scratch_ / "lf", {}); }), HasSubstr("'sky_color'"));
  // Also where the set's reader ends.
  fs::remove(set() / "images/shot_0.png");
  document_["frames"][2]["mask_path"] = "gone.png";
  document_["frames"][1]["w"] = 2 * kWidth;  // resized
  document_["frames"][1]["h"] = 2 * kHeight;
  EXPECT_THAT(SaidBeforeFailing([&] { Read(); }), HasSubstr("photographs of 64x48 for a camera of 128x96"));
}

TEST_F(StrangersSet, SaysWhyThereIsNoSubject) {
  const json before = document_;
  const auto expect = [&](const std::string& words) {
    Read();
    EXPECT_THAT([&] { Import(set(), scratch_ / "lf", {}); },
                ThrowsMessage<Refusal>(AllOf(HasSubstr(words), HasSubstr("subject x,y,z,radius"))));
    EXPECT_FALSE(fs::exists(scratch_ / "lf"));
    document_ = before;
  };
  for (int i = 0; i < 5; ++i) Pose(i, WorldFromCam(0));
  expect("all cameras stand at one place");
  document_["frames"].erase(document_["frames"].begin() + 1, document_["frames"].end());
  expect("one photograph alone");
  for (int i = 3; i < 5; ++i) {  // two of five look at something else
    Matrix4d moved = WorldFromCam(i);
    moved(0, 3) += 200;
    Pose(i, moved);
  }
  Matrix4d turned = WorldFromCam(2);  // and one at nothing
  turned.topLeftCorner<3, 3>() *= Eigen::AngleAxisd(1.5, Vector3d::UnitY()).toRotationMatrix();
  Pose(2, turned);
  expect("two groups far apart (3 cameras around");
  // A set at one place whose subject is given is told.
  for (int i = 0; i < 5; ++i) Pose(i, WorldFromCam(0));
  Read();
  const LightField made = Import(set(), scratch_ / "lf", {.subject = Subject{{0, 0, 3}, 0.4}}).light_field;
  ASSERT_EQ(made.findings.size(), 1u);
  EXPECT_THAT(made.findings[0].text, HasSubstr("stand at one place"));
}

// ---- Lenses by other formulas ----

TEST(CameraFit, FindsTheModelThatShowsTheSame) {
  CameraModel truth = CameraModel::Pinhole(640, 480, 500);
  truth.fy = 505;
  truth.cx = 310;
  truth.distortion = Distortion::kRadialTangential;
  truth.coefficients = {-0.2, 0.05, 0.001, -0.002, -0.01};
  const Projection project = [&](const Vector3d& point) { return truth.ImgFromCam(point); };
  CameraModel start = CameraModel::Pinhole(640, 480, 480);
  start.distortion = Distortion::kRadialTangential;
  const CameraFit fit = FitCamera(project, start);
  EXPECT_LT(fit.largest_px, 1e-6);
  EXPECT_NEAR(fit.camera.fx, 500, 1e-4);
  EXPECT_GT(CompareCamera(project, start).largest_px, 10);
}

// A skew of 3 px, which no model of ours has.
TEST(CameraFit, SaysHowFarTheNearestModelIs) {
  const Projection project = [](const Vector3d& p) -> std::optional<Vector2d> {
    if (p.z() <= 0) return std::nullopt;
    const double x = p.x() / p.z(), y = p.y() / p.z();
    return Vector2d(320 + 300 * x + 3 * y, 240 + 300 * y);
  };
  CameraModel start = CameraModel::Pinhole(640, 480, 300);
  start.distortion = Distortion::kRadialTangential;
  const CameraFit fit = FitCamera(project, start);
  double largest = 0, squares = 0;  // counted here over a grid of its own
  int count = 0;
  for (double x = -1.06; x <= 1.06; x += 0.02)
    for (double y = -0.79; y <= 0.79; y += 0.02)
      if (const auto shown = project({x, y, 1}); start.Contains(*shown)) {
        const double distance = (*fit.camera.ImgFromCam({x, y, 1}) - *shown).norm();
        largest = std::max(largest, distance);
        squares += distance * distance;
        ++count;
      }
  EXPECT_GT(largest, 0.5);
  EXPECT_NEAR(largest, fit.largest_px, 0.1 * largest);
  EXPECT_NEAR(std::sqrt(squares / count), fit.rms_px, 0.1 * fit.rms_px);
}

}  // namespace
}  // namespace ulf::set_tolerance_test
