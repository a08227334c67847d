// Tests: acquisition/calibration/calibration_io, core/geometry/camera_json.
#include "acquisition/calibration/calibration_io.h"

#include <gmock/gmock.h>

#include <fstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::calibration_io_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

CameraModel SomeCamera() {
  return {640,
          480,
          512.25,
          511.75,
          321.5,
          238.25,
          Distortion::kRadialTangential,
          {-0.1, 0.02, 1e-4, -2e-4, 0.001}};
}

void WriteText(const std::filesystem::path& path, const std::string& text) { std::ofstream(path) << text; }

TEST(CalibrationIo, ComesBackAsItWasWritten) {
  const test::ScratchFolder scratch;
  for (const Distortion distortion :
       {Distortion::kNone, Distortion::kRadialTangential, Distortion::kFisheye}) {
    CameraModel camera = SomeCamera();
    camera.distortion = distortion;
    const auto path = scratch / ("camera" + std::to_string(static_cast<int>(distortion)) + ".json");
    WriteCalibration(path, camera, "S1", "a test");
    EXPECT_EQ(ReadCalibration(path), camera);
  }
}

TEST(CalibrationIo, KeepsOtherModesOfTheSameCamera) {
  const test::ScratchFolder scratch;
  const auto path = scratch / "camera.json";
  CameraModel still = SomeCamera().ScaledTo(1280, 960);
  WriteCalibration(path, SomeCamera(), "S1", "a test");
  WriteCalibration(path, still, "S1", "a test", "still");
  EXPECT_EQ(ReadCalibration(path), SomeCamera());
  EXPECT_EQ(ReadCalibration(path, "still"), still);
}

TEST(CalibrationIo, NeverOverwritesAnotherCameraOrFile) {
  const test::ScratchFolder scratch;
  const auto path = scratch / "camera.json";
  WriteCalibration(path, SomeCamera(), "S1", "a test");
  const std::string before = ReadWholeFile(path);
  EXPECT_THAT(
      [&] { WriteCalibration(path, SomeCamera(), "S2", "another camera"); },
      testing::ThrowsMessage<Error>(AllOf(HasSubstr("S1"), HasSubstr("S2"), HasSubstr("another file"))))
      << "written over";
  EXPECT_EQ(ReadWholeFile(path), before);
  WriteText(scratch / "photo.jpg", "no calibration");
  EXPECT_THROW(WriteCalibration(scratch / "photo.jpg", SomeCamera(), "S1", "a test"), Error);
  EXPECT_EQ(ReadWholeFile(scratch / "photo.jpg"), "no calibration");
}

TEST(CalibrationIo, LineOfNumbersCountsAsOpenCvDoes) {
  const test::ScratchFolder scratch;
  const auto path = scratch / "intrinsics.txt";
  WriteText(
      path,
      "# fx fy cx cy k1 k2 p1 p2 width height fps\n527.39 527.5 320 240 -0.02427 0.1 0.2 0.3 640 480 30\n");
  const CameraModel camera = ReadCalibration(path);
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 480);
  EXPECT_EQ(camera.fx, 527.39);
  EXPECT_EQ(camera.fy, 527.5);
  EXPECT_EQ(camera.cx, 320.5) << "pixel centres are at one half here";
  EXPECT_EQ(camera.cy, 240.5);
  EXPECT_THAT(camera.coefficients, ::testing::ElementsAre(-0.02427, 0.1, 0.2, 0.3, 0));
}

TEST(CalibrationIo, ErrorsNameFileAndTrouble) {
  const test::ScratchFolder scratch;
  const std::pair<const char*, const char*> kCases[] = {
      {"", "empty"},
      {"hello", "no calibration that ulf knows. Lenses of ulf"},
      {"500 500 320 240", "4 numbers"},
      {"-500 500 320 240 0 0 0 0 640 480", "focal"},
      {"500 500 320 240 0 0 0 0 1e118 480", "width and height"},
      {"500 500 320 240 0 0 0 0 640 0.5", "width and height"},
      {"517 516 318 255 0.26 -0.95 -0.005 0.003 1.16 640 480", "whole numbers"},
      {"500 500 0.5 0.5 0 0 0 0 640 480", "corner of pictures"},
      {"600 0 320\n0 600 240\n0 0 1\n", "matrix alone"},
      {"# Bundle file v0.3\n1 0\n600 0.1 0.2\n1 0 0\n0 1 0\n0 0 1\n0 0 0\n", "Bundler"},
      {"{\"modes\": ", "JSON"},
      {"{\"modes\": 1e999}", "too large"},
      {"{}", "modes"},
      {"{\"modes\": []}", "live"},
      {"{\"modes\": {\"still\": {}}}", "still"},
      {"{\"modes\": {\"live\": {\"width\": 640}}}", "height"},
      {"{\"modes\": {\"live\": {\"width\": 640, \"height\": 480, \"fx\": \"wide\", \"fy\": 1, \"cx\": 1, "
       "\"cy\": 1}}}",
       "fx"},
      {"{\"modes\": {\"live\": {\"width\": 640, \"height\": 480, \"fx\": 500, \"fy\": 500, \"cx\": 1, "
       "\"cy\": 1, "
       "\"distortion\": \"odd\"}}}",
       "odd"},
  };
  const auto path = scratch / "bad.json";
  for (const auto& [text, mentioned] : kCases) {
    WriteText(path, text);
    EXPECT_THAT([&] { ReadCalibration(path); },
                testing::ThrowsMessage<Error>(testing::AllOf(HasSubstr("bad.json"), HasSubstr(mentioned))))
        << text;
  }
  EXPECT_THROW(ReadCalibration(scratch / "absent.json"), Error);
  EXPECT_THROW(ReadCalibration(scratch.path()), Error) << "a folder";
}

}  // namespace
}  // namespace ulf::calibration_io_test
