// Tests: acquisition/calibration/calibration_formats, commands/calibration/calibration_command.
#include "acquisition/calibration/calibration_formats.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/calibration/lens_files/lens_files.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::calibration_formats_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr CalibrationFormat kAll[] = {CalibrationFormat::kKalibr, CalibrationFormat::kRos,
                                      CalibrationFormat::kOpenCv, CalibrationFormat::kColmap};

CameraModel SomeCamera(Distortion distortion) {
  CameraModel camera{640, 480, 512.25, 511.75, 321.5, 238.25, distortion, {}};
  if (distortion == Distortion::kRadialTangential) camera.coefficients = {-0.1, 0.02, 1e-4, -2e-4, 0};
  if (distortion == Distortion::kFisheye) camera.coefficients = {0.03, -0.012, 0.004, -0.0015, 0};
  return camera;
}

// Of the format's name, which the reader must recognise.
CameraModel ReadAs(CalibrationFormat format, const std::string& text, const std::string& camera = "") {
  const std::optional<ReadLens> read = ReadLensText(text, "the file", camera);
  EXPECT_TRUE(read) << text;
  if (!read) return {};
  std::string program = read->program;
  std::ranges::transform(program, program.begin(), [](unsigned char c) { return std::tolower(c); });
  EXPECT_EQ(program, Name(format)) << text;
  EXPECT_THAT(read->lens.warnings, IsEmpty()) << text;
  return read->lens.camera;
}

std::string ErrorOf(const std::string& text) {
  try {
    if (!ReadLensText(text, "the file")) return "not recognised";
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CalibrationFormats, ComeBackAsTheyWereWritten) {
  for (const CalibrationFormat format : kAll)
    for (const Distortion distortion :
         {Distortion::kNone, Distortion::kRadialTangential, Distortion::kFisheye}) {
      const CameraModel camera = SomeCamera(distortion);
      for (const bool xml : {false, true}) {
        const std::string text = CalibrationText(format, camera, "S1", xml);
        const CameraModel read = ReadAs(format, text);
        EXPECT_EQ(read.distortion, distortion) << Name(format);
        EXPECT_NEAR(read.cx, camera.cx, 1e-12) << Name(format);
        EXPECT_NEAR(read.fy, camera.fy, 1e-12) << Name(format);
        for (std::size_t i = 0; i < 5; ++i)
          EXPECT_DOUBLE_EQ(read.coefficients[i], camera.coefficients[i]) << Name(format) << " " << i;
      }
    }
}

// An image of 641 x 481 pixels whose principal point is the very middle: by hand, 320 and 240 where centres
// are integers, 320.5 and 240.5 where the first pixel's centre is one half.
TEST(CalibrationFormats, HalfPixelIsAsWorkedOutByHand) {
  const CameraModel middle{641, 481, 500, 500, 320.5, 240.5, Distortion::kNone, {}};
  EXPECT_THAT(CalibrationText(CalibrationFormat::kKalibr, middle, ""), HasSubstr("[500, 500, 320, 240]"));
  EXPECT_THAT(CalibrationText(CalibrationFormat::kRos, middle, ""),
              HasSubstr("data: [500, 0, 320, 0, 500, 240, 0, 0, 1]"));
  EXPECT_THAT(CalibrationText(CalibrationFormat::kColmap, middle, ""),
              HasSubstr("SIMPLE_PINHOLE 641 481 500 320.5 240.5"));
  EXPECT_THAT(CalibrationText(CalibrationFormat::kOpenCv, middle, ""),
              HasSubstr("500., 0., 320., 0., 500., 240., 0., 0., 1."));
}

TEST(CalibrationFormats, KalibrIsAsWorkedOutByHand) {
  const std::string text =
      "cam0:\n  cam_overlaps: [1]\n  camera_model: pinhole\n  distortion_coeffs: [-0.28, 0.07, 1.9e-04, "
      "1.8e-05]\n"
      "  distortion_model: radtan\n  intrinsics: [458.654, 457.296, 367.215, 248.375]\n  resolution: [752, "
      "480]\n"
      "  rostopic: /cam0/image_raw\n"
      "cam1:\n  camera_model: pinhole\n  distortion_coeffs: [0.01, 0.02, 0.03, 0.04]\n"
      "  distortion_model: equidistant\n  intrinsics: [400, 401, 375.5, 239.5]\n  resolution: [752, 480]\n";
  const CameraModel first = ReadAs(CalibrationFormat::kKalibr, text, "cam0");
  EXPECT_EQ(first.cx, 367.715);
  EXPECT_EQ(first.cy, 248.875);
  EXPECT_EQ(first.fy, 457.296);
  EXPECT_THAT(first.coefficients, ElementsAre(-0.28, 0.07, 1.9e-4, 1.8e-5, 0));
  const CameraModel second = ReadAs(CalibrationFormat::kKalibr, text, "cam1");
  EXPECT_EQ(second.distortion, Distortion::kFisheye);
  EXPECT_EQ(second.cx, 376);
  EXPECT_THAT(second.coefficients, ElementsAre(0.01, 0.02, 0.03, 0.04, 0));
  EXPECT_THAT(ErrorOf(text), HasSubstr("2 cameras"));
}

TEST(CalibrationFormats, RosIsAsWorkedOutByHand) {
  const CameraModel camera = ReadAs(
      CalibrationFormat::kRos,
      "image_width: 640\nimage_height: 480\ncamera_name: head_camera\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: [600, 0, 319.5, 0, 602, 239.5, 0, 0, 1]\ndistortion_model: "
      "plumb_bob\ndistortion_coefficients:\n"
      "  rows: 1\n  cols: 5\n  data: [0.1, -0.2, 0.001, 0.002, 0.3]\n");
  EXPECT_EQ(camera.cx, 320);
  EXPECT_EQ(camera.cy, 240);
  EXPECT_EQ(camera.fy, 602);
  EXPECT_THAT(camera.coefficients, ElementsAre(0.1, -0.2, 0.001, 0.002, 0.3));
}

TEST(CalibrationFormats, OpenCvIsAsWorkedOutByHand) {
  const CameraModel camera =
      ReadAs(CalibrationFormat::kOpenCv,
             "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: "
             "!!opencv-matrix\n   rows: 3\n   cols: 3\n"
             "   dt: d\n   data: [ 600., 0., 319.5, 0., 602., 239.5, 0., 0., 1. ]\n"
             "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
             "   data: [ 0.1, -0.2, 0.001, 0.002, 0.3 ]\n");
  EXPECT_EQ(camera.cx, 320);
  EXPECT_EQ(camera.fx, 600);
  EXPECT_THAT(camera.coefficients, ElementsAre(0.1, -0.2, 0.001, 0.002, 0.3));
}

TEST(CalibrationFormats, ColmapIsAsWorkedOutByHand) {
  const auto read = [](const std::string& line) {
    return ReadAs(CalibrationFormat::kColmap, "# Camera list\n" + line + "\n");
  };
  const CameraModel simple = read("1 SIMPLE_RADIAL 640 480 600 320 240 -0.05");
  EXPECT_EQ(simple.fy, 600);
  EXPECT_EQ(simple.cx, 320) << "COLMAP counts as we do";
  EXPECT_THAT(simple.coefficients, ElementsAre(-0.05, 0, 0, 0, 0));
  const CameraModel full = read("7 FULL_OPENCV 640 480 600 601 320 240 1 2 3 4 5 0 0 0");
  EXPECT_THAT(full.coefficients, ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(read("1 OPENCV_FISHEYE 640 480 300 300 320 240 0.1 0.2 0.3 0.4").distortion,
            Distortion::kFisheye);
}

TEST(CalibrationFormats, InexpressibleLensIsANamedError) {
  EXPECT_THAT(ErrorOf("1 FOV 640 480 600 600 320 240 0.9\n"), HasSubstr("FOV"));
  EXPECT_THAT(ErrorOf("1 THIN_PRISM_FISHEYE 640 480 600 600 320 240 0 0 0.001 0 0 0 0 0\n"),
              HasSubstr("THIN_PRISM_FISHEYE"));
  EXPECT_THAT(ErrorOf("1 FULL_OPENCV 640 480 600 601 320 240 1 2 3 4 5 0.1 0 0\n"), HasSubstr("rational"));
  EXPECT_THAT(ErrorOf("1 PINHOLE 640 480 600 601 320\n"), HasSubstr("parameters"));
  EXPECT_THAT(ErrorOf("cam0:\n  camera_model: ds\n  intrinsics: [1, 2, 3, 4, 5, 6]\n"), HasSubstr("'ds'"));
  EXPECT_THAT(
      ErrorOf("cam0:\n  camera_model: pinhole\n  intrinsics: [500, 500, 320, 240]\n  resolution: [640, 480]\n"
              "  distortion_model: fov\n  distortion_coeffs: [0.9]\n"),
      HasSubstr("'fov'"));
  EXPECT_THAT(
      ErrorOf(
          "image_width: 640\nimage_height: 480\ncamera_matrix:\n  data: [600, 0, 320, 0, 600, 240, 0, 0, 1]\n"
          "distortion_model: rational_polynomial\ndistortion_coefficients:\n"
          "  data: [1, 2, 3, 4, 5, 6, 7, 8]\n"),
      HasSubstr("rational"));
  CameraModel with_k3 = SomeCamera(Distortion::kRadialTangential);
  with_k3.coefficients[4] = 0.1;
  EXPECT_THROW(CalibrationText(CalibrationFormat::kKalibr, with_k3, ""), Error);
  for (const char* torn :
       {"cam0:\n  camera_model: pinhole\n  intrinsics: [500, 500", "%YAML:1.0\n---\ncamera_matrix: 3\n",
        "<?xml version=\"1.0\"?>\n<opencv_storage>", "camera_matrix: [\n"})
    EXPECT_THAT(ErrorOf(torn), HasSubstr("the file")) << torn;
}

TEST(CalibrationFormats, RefuseTooDeepNesting) {
  constexpr int kLevels = 102;
  std::string tags = "<?xml version=\"1.0\"?>\n<opencv_storage>\n", ends;
  std::string keys = "%YAML:1.0\n---\ncamera_matrix: 1\n", items = keys, indented = keys;
  for (int i = 0; i < kLevels; ++i) {
    if (i > 0) tags += "<a>", ends += "</a>";  // within the first
    keys += "a: ";
    items += "- ";
    indented += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  }
  const std::string open(kLevels, '['), brackets = open + "1" + std::string(kLevels, ']') + "\n";
  for (const std::string& deep :
       {"%YAML:1.0\n---\ncamera_matrix: " + brackets, tags + ends + "\n</opencv_storage>\n", keys + "1\n",
        items + "1\n", indented + std::string(kLevels, ' ') + "a: 1\n"})
    EXPECT_THAT(ErrorOf(deep), AllOf(HasSubstr("the file"), HasSubstr("nested too deeply"))) << deep;
}

TEST(CalibrationFormats, AMatrixIsAsLargeAsItsNumbersSay) {
  for (const char* rows : {"rows: 3000000", "rows: three", "rows:=3", "rows: -3"})
    EXPECT_THAT(
        ErrorOf(fmt::format("%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: "
                            "!!opencv-matrix\n   {}\n   cols: 3\n   dt: d\n   data: [ 600., 0., 319.5, 0., "
                            "602., 239.5, 0., 0., 1. ]\n",
                            rows)),
        AllOf(HasSubstr("the file"), HasSubstr("camera_matrix"), HasSubstr("rows")))
        << rows;
}

TEST(CalibrationFormats, AreReadWhereverACalibrationIs) {
  const test::ScratchFolder scratch;
  for (const CalibrationFormat format : kAll) {
    const auto path = scratch / Name(format);
    WriteFileAtomically(path, CalibrationText(format, SomeCamera(Distortion::kFisheye), "S1"));
    EXPECT_EQ(ReadCalibration(path).distortion, Distortion::kFisheye);
    EXPECT_NEAR(ReadCalibration(path).cx, 321.5, 1e-12);
  }
}

TEST(CalibrationCommand, ConvertsThereAndBack) {
  const test::ScratchFolder scratch;
  const std::string ours = (scratch / "camera.json").string();
  WriteCalibration(ours, SomeCamera(Distortion::kRadialTangential), "S1", "a test");
  for (const CalibrationFormat format : kAll) {
    const std::string theirs = (scratch / (std::string("out.") + Name(format))).string();
    const std::string back = (scratch / (std::string(Name(format)) + ".json")).string();
    auto result = test::RunUlf("calibration " + ours + " --to " + Name(format) + " -o " + theirs);
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    result = test::RunUlf("calibration " + theirs + " -o " + back + " --json");
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_NEAR(ReadCalibration(back).cy, 238.25, 1e-12) << Name(format);
  }
  // What is there is not replaced unasked, except by the same bytes, or by itself with more in it.
  const std::string kalibr = (scratch / "out.kalibr").string(), before = ReadWholeFile(kalibr);
  for (const std::string& command :
       {"calibration " + ours + " --to ros -o " + kalibr, "calibration " + kalibr + " --to ulf -o " + ours,
        "calibration " + ours + " --to ulf -o " + kalibr}) {
    const auto refused = test::RunUlf(command);
    EXPECT_EQ(refused.exit_code, 2) << command;
    EXPECT_THAT(refused.errors, AllOf(HasSubstr("exists already"), HasSubstr("choose another name")))
        << command;
  }
  EXPECT_EQ(ReadWholeFile(kalibr), before);
  EXPECT_EQ(test::RunUlf("calibration " + ours + " --to kalibr -o " + kalibr).exit_code, 0);
  EXPECT_EQ(test::RunUlf("calibration " + ours + " --model M -o " + ours).exit_code, 0);
  EXPECT_EQ(ReadCalibrationFile(ours).identity.model, "M");
  // Another program's file holds more than a lens, such as a set's poses.
  const std::string set = (scratch / "transforms.json").string(),
                    poses =
                        "{\"w\": 640, \"h\": 480, \"fl_x\": 600, \"frames\": [{\"file_path\": \"1.png\"}]}";
  WriteFileAtomically(set, poses);
  EXPECT_THAT(test::RunUlf("calibration " + set + " --serial S1 -o " + set).errors,
              HasSubstr("exists already"));
  EXPECT_EQ(ReadWholeFile(set), poses);
  EXPECT_EQ(test::RunUlf("calibration " + ours + " --to maya -o x").exit_code, 2);
  EXPECT_EQ(test::RunUlf("calibration " + ours + " --to ros").exit_code, 2);
  EXPECT_THAT(test::RunUlf("calibration " + ours).output, HasSubstr("S1"));
}

TEST(CalibrationCommand, FormatIsByFileNameOrAskedFor) {
  const test::ScratchFolder scratch;
  const std::string ours = (scratch / "camera.json").string();
  WriteCalibration(ours, SomeCamera(Distortion::kRadialTangential), "S1", "a test");
  const auto format_of = [&](const std::string& name) -> std::string {
    const auto result = test::RunUlf("calibration " + ours + " -o " + (scratch / name).string());
    if (result.exit_code != 0) return result.errors;
    const std::string source = ReadCalibrationFile(scratch / name).source;
    return source == "a test" ? "ulf" : source;
  };
  EXPECT_EQ(format_of("a.json"), "ulf");
  EXPECT_EQ(format_of("a.xml"), "OpenCV file");
  EXPECT_EQ(format_of("cameras.txt"), "COLMAP file");
  for (const char* name : {"a.yaml", "a.yml", "a"}) {
    EXPECT_THAT(format_of(name), AllOf(HasSubstr("--to"), HasSubstr("kalibr"), HasSubstr("opencv"))) << name;
    EXPECT_FALSE(std::filesystem::exists(scratch / name)) << name;
  }
}

// A file of another program names no camera and no part of a sensor: both can be said, and then hold.
TEST(CalibrationCommand, BindsAFileToACameraAndRegion) {
  const test::ScratchFolder scratch;
  const std::string theirs = (scratch / "camchain.yaml").string(), bound = (scratch / "bound.json").string();
  WriteFileAtomically(theirs,
                      CalibrationText(CalibrationFormat::kKalibr, SomeCamera(Distortion::kFisheye), ""));
  const std::string start = "calibration " + theirs + " -o " + bound;
  auto result =
      test::RunUlf(start + " --serial S9 --model Cam --sensor 2048x1536 --roi 640x480+16+8 --binning 2x2");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const CalibrationFile file = ReadCalibrationFile(bound);
  EXPECT_EQ(file.identity.serial, "S9");
  EXPECT_EQ(file.identity.model, "Cam");
  EXPECT_EQ(file.modes.at("live").window, (SensorWindow{2048, 1536, 32, 16, 1280, 960, 2, 2}));

  const auto refused = [](const std::string& command) {
    const auto answer = test::RunUlf(command);
    EXPECT_EQ(answer.exit_code, 2) << command;
    return answer.errors;
  };
  EXPECT_THAT(refused("calibration " + bound + " --serial S8 -o " + (scratch / "b.json").string()),
              AllOf(HasSubstr("S8"), HasSubstr("S9")));
  EXPECT_THAT(refused(start + " --sensor 2048x1536"), HasSubstr("--roi 640x480+X+Y"));
  EXPECT_THAT(refused(start + " --roi 640x480+0+0"), HasSubstr("--sensor"));
  EXPECT_THAT(refused(start + " --sensor 2048x1536 --roi 320x240+0+0"), HasSubstr("640x480"));
  EXPECT_THAT(refused(start + " --sensor 2048x1536 --roi 640x480+1409+0"), HasSubstr("beyond"));
  EXPECT_THAT(refused("calibration " + theirs + " --serial S9"),
              AllOf(HasSubstr("-o"), HasSubstr("S9.json")));
  EXPECT_THAT(test::RunUlf("calibration " + theirs).output, HasSubstr("not bound"));
}

}  // namespace
}  // namespace ulf::calibration_formats_test
