// Tests: acquisition/calibration/lens_files/lens_files, acquisition/calibration/lens_files/lens_tree,
// acquisition/calibration/lens_files/lens_words, acquisition/calibration/lens_files/matrix_files.
//
// What is read: files with a camera matrix, of OpenCV and ROS, by texts written here, with the numbers that
// they must give.
#include "acquisition/calibration/lens_files/lens_files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_io.h"
#include "tests/acquisition/calibration/lens_files/lens_texts.h"
#include "tests/support/test_paths.h"

namespace ulf::lens_files_test {
using namespace lens_texts;
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// OpenCV's YAML, with `words` between the matrices.
std::string OpenCvYaml(const std::string& words, const std::string& d,
                       const char* head = "%YAML:1.0\n---\n") {
  return fmt::format(
      "{}image_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n"
      "   dt: d\n   data: {}\n{}distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: {}\n"
      "   dt: d\n   data: {}\n",
      head, kK, words, std::ranges::count(d, ',') + 1, d);
}
std::string RosYaml(const std::string& words, const std::string& d) {
  return fmt::format(
      "image_width: 640\nimage_height: 480\ncamera_name: cam\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: {}\n{}distortion_coefficients:\n  rows: 1\n  cols: {}\n  data: {}\n"
      "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n",
      kK, words, std::ranges::count(d, ',') + 1, d);
}
std::string OpenCvXml(const std::string& words) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>640</image_width>\n"
      "<image_height>480</image_height>\n<camera_matrix type_id=\"opencv-matrix\"><rows>3</rows>"
      "<cols>3</cols><dt>d</dt><data>\n600.5 0. 320.5\n0. 601.25 239.25 0. 0. 1.</data></camera_matrix>\n"
      "{}<distortion_coefficients type_id=\"opencv-matrix\"><rows>4</rows><cols>1</cols><dt>d</dt><data>"
      "\n-0.01 0.002 -0.003 4e-4</data></distortion_coefficients>\n</opencv_storage>\n",
      words);
}
std::string OpenCvJson(const std::string& words) {
  return fmt::format(
      "{{\"image_width\": 640, \"image_height\": 480, {}\"camera_matrix\": {{\"type_id\": \"opencv-matrix\", "
      "\"rows\": "
      "3, \"cols\": 3, \"dt\": \"d\", \"data\": {}}}, \"distortion_coefficients\": {{\"type_id\": "
      "\"opencv-matrix\", "
      "\"rows\": 4, \"cols\": 1, \"dt\": \"d\", \"data\": {}}}}}",
      words, kK, kFisheyeD);
}

TEST(LensFiles, ModelNameDecidesInEveryFormat) {
  for (const char* word : {"equidistant", "fisheye", "kannala_brandt", "Kannala_Brandt4", "KannalaBrandt8",
                           "kb4", "EQUIDISTANT", "opencv_fisheye"}) {
    const std::string line = fmt::format("distortion_model: {}\n", word);
    for (const std::string& text :
         {OpenCvYaml(line, kFisheyeD), OpenCvYaml(line, kFisheyeD, ""),
          OpenCvYaml(line, kFisheyeD, "%YAML 1.0\n---\n"), RosYaml(line, kFisheyeD),
          OpenCvXml(fmt::format("<distortion_model>{}</distortion_model>\n", word)),
          OpenCvXml(fmt::format("<distortion_model>\"{}\"</distortion_model>\n", word)),
          OpenCvJson(fmt::format("\"distortion_model\": \"{}\", ", word)),
          OpenCvYaml(fmt::format("camera_model: pinhole\nmodel: \"{}\"\n", word), kFisheyeD),
          OpenCvYaml(fmt::format("camera_model: {}\n", word), kFisheyeD),
          fmt::format("camera:\n  type: {}\n  width: 640\n  height: 480\n  K: {}\n  D: {}\n", word, kK,
                      kFisheyeD)}) {
      SCOPED_TRACE(text);
      const ReadLens read = Read(text);
      ExpectLens(read, Fisheye());
      EXPECT_THAT(read.lens.warnings, IsEmpty());
    }
  }
  for (const char* word : {"plumb_bob", "radtan", "radial-tangential", "Brown-Conrady", "plumb bob"})
    for (const std::string& text : {OpenCvYaml(fmt::format("distortion_model: {}\n", word), kRadialD),
                                    RosYaml(fmt::format("distortion_model: {}\n", word), kRadialD)}) {
      const ReadLens read = Read(text);
      ExpectLens(read, Radial());
      EXPECT_THAT(read.lens.warnings, IsEmpty()) << text;
    }
  for (const char* model : {"fisheye_model: 1\n", "fisheye: true\n", "is_fisheye: yes\n"})
    ExpectLens(Read(OpenCvYaml(model, kFisheyeD)), Fisheye());
  ExpectLens(Read(OpenCvXml("<fisheye_model>1</fisheye_model>")), Fisheye());
  ExpectLens(Read(OpenCvJson("\"fisheye_model\": true, ")), Fisheye());
  ExpectLens(Read(OpenCvYaml("distortion_model: rational_polynomial\n",
                             "[-0.1, 0.05, 0.001, -0.002, 0.25, 0, 0, 0]")),
             Radial(0.25));
  // The maker's model is none of the lens.
  ExpectLens(Read(OpenCvYaml("fisheye_model: 0\nmodel: OmniVision generic\n", kRadialD)), Radial());
}

TEST(LensFiles, FourUnnamedNumbersCauseAWarning) {
  const std::string pair = fmt::format(
      "%YAML:1.0\n---\nK: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: {}\nD: "
      "!!opencv-matrix\n"
      "   rows: 4\n   cols: 1\n   dt: d\n   data: {}\nwidth: 640\nheight: 480\n",
      kK, kRadialD);
  for (const std::string& text :
       {pair, OpenCvYaml("", kRadialD), OpenCvYaml("camera_model: pinhole\n", kRadialD),
        fmt::format("{{\"K\": {}, \"D\": [{}], \"image_size\": [640, 480]}}", kK, kRadialD)}) {
    const ReadLens read = Read(text);
    ExpectLens(read, Radial());
    ASSERT_EQ(read.lens.warnings.size(), 1u) << text;
    EXPECT_THAT(read.lens.warnings[0],
                AllOf(HasSubstr("the file"), HasSubstr("four coefficients"), HasSubstr("k1 k2 p1 p2"),
                      HasSubstr("k1 k2 k3 k4"), HasSubstr("fisheye_model: 1"),
                      HasSubstr("distortion_model: equidistant")));
  }
  EXPECT_THAT(Read(OpenCvYaml("", "[-0.1, 0.05, 0.001, -0.002, 0.5]")).lens.warnings, IsEmpty());
  EXPECT_THAT(Read(OpenCvYaml("", "[0, 0, 0, 0]")).lens.warnings, IsEmpty());
}

TEST(LensFiles, RosWithoutAModelIsPlumbBobAndSaysSo) {
  for (const char* words : {"", "distortion_model: \"\"\n", "distortion_model:\n"}) {
    const ReadLens read = Read(RosYaml(words, "[-0.1, 0.05, 0.001, -0.002, 0.5]"));
    ExpectLens(read, Radial(0.5));
    EXPECT_EQ(read.program, "ROS");
    ASSERT_EQ(read.lens.warnings.size(), 1u) << words;
    EXPECT_THAT(read.lens.warnings[0], AllOf(HasSubstr("plumb_bob"), HasSubstr("as ROS takes it")));
  }
  const ReadLens plain =
      Read(fmt::format("image_width: 640\nimage_height: 480\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: "
                       "{}\ndistortion_model: ''\n"
                       "distortion_coefficients:\n  rows: 1\n  cols: 0\n  data: []\n",
                       kK));
  EXPECT_EQ(plain.lens.camera.distortion, Distortion::kNone);
  EXPECT_THAT(plain.lens.warnings, ElementsAre(HasSubstr("plumb_bob")));
}

std::string RosEcho(const std::string& k, const std::string& d, const std::string& model,
                    const std::string& more = "") {
  return fmt::format(
      "header:\n  seq: 12\n  stamp:\n    secs: 1700000000\n    nsecs: 5\n  frame_id: \"cam\"\nheight: 480\n"
      "width: 640\ndistortion_model: \"{}\"\n{}: {}\n{}: {}\nR: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, "
      "1.0]\n{}---\n",
      model, k[0] == 'K' ? "D" : "d", d, k, kK, more);
}

TEST(LensFiles, RosEchoesAndOstAreRead) {
  const std::string five = "[-0.1, 0.05, 0.001, -0.002, 0.0]";
  for (const char* k : {"K", "k"}) {
    const ReadLens read = Read(RosEcho(k, five, "plumb_bob"));
    ExpectLens(read, Radial());
    EXPECT_EQ(read.program, "ROS");
    EXPECT_THAT(read.lens.warnings, IsEmpty());
    ExpectLens(Read(RosEcho(k, kFisheyeD, "equidistant")), Fisheye());
  }
  // With the line ends of Windows.
  std::string windows;
  for (const char c : RosEcho("k", five, "plumb_bob")) windows += c == '\n' ? "\r\n" : std::string(1, c);
  ExpectLens(Read(windows), Radial());
  // Messages of one topic repeat the lens; where it was set anew between them, one is to be named.
  const std::string first = RosEcho("k", five, "plumb_bob"), other = RosEcho("k", kFisheyeD, "equidistant");
  ExpectLens(Read(first + first + first), Radial());
  EXPECT_THAT(ErrorOf(first + first + other),
              AllOf(HasSubstr("3 cameras (1, 2, 3)"), HasSubstr("extract one")));
  ExpectLens(Read(first + first + other, "3"), Fisheye());
  // As ROS 2 prints it, one number a line.
  std::string lines =
      "header:\n  stamp:\n    sec: 1\n    nanosec: 2\n  frame_id: cam\nheight: 480\nwidth: 640\n"
      "distortion_model: plumb_bob\nd:\n- -0.1\n- 0.05\n- 0.001\n- -0.002\n- 0.0\nk:\n";
  for (const char* number : {"600.5", "0.0", "320.5", "0.0", "601.25", "239.25", "0.0", "0.0", "1.0"})
    lines += fmt::format("- {}\n", number);
  ExpectLens(
      Read(lines +
           "binning_x: 0\nbinning_y: 0\nroi:\n  x_offset: 0\n  y_offset: 0\n  height: 0\n  width: 0\n"),
      Radial());
  EXPECT_THAT(Read(lines + "binning_x: 2\nbinning_y: 2\n").lens.warnings,
              ElementsAre(HasSubstr("binning 2x2")));
  EXPECT_THAT(
      Read(lines + "roi:\n  x_offset: 16\n  y_offset: 8\n  height: 240\n  width: 320\n").lens.warnings,
      ElementsAre(HasSubstr("roi 320x240+16+8")));

  const std::string camera =
      "camera matrix\n600.500000 0.000000 320.500000\n0.000000 601.250000 239.250000\n0.000000 0.000000 "
      "1.000000\n\n"
      "distortion\n-0.100000 0.050000 0.001000 -0.002000 0.000000\n\nrectification\n1 0 0\n0 1 0\n0 0 1\n";
  const std::string image = "# oST version 5.0 parameters\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n";
  const std::string projection = "\nprojection\n600.5 0 320.5 0\n0 601.25 239.25 0\n0 0 1 0\n";
  const ReadLens ost = Read(image + "[narrow_stereo]\n\n" + camera + projection);
  ExpectLens(ost, Radial());
  EXPECT_EQ(ost.program, "ROS");
  EXPECT_THAT(ost.lens.warnings, ElementsAre(HasSubstr("plumb_bob")));
  const std::string pair =
      image + "[narrow_stereo/left]\n\n" + camera + image + "[narrow_stereo/right]\n\n" + camera;
  EXPECT_THAT(ErrorOf(pair), HasSubstr("narrow_stereo/left, narrow_stereo/right"));
  ExpectLens(Read(pair, "narrow_stereo/right"), Radial());
}

TEST(LensFiles, SizesAndMatricesOfScriptsAreRead) {
  const std::string rows =
      "- - 600.5\n  - 0.0\n  - 320.5\n- - 0.0\n  - 601.25\n  - 239.25\n- - 0.0\n  - 0.0\n  - 1.0\n";
  const std::string d = "dist_coeff:\n- - -0.1\n  - 0.05\n  - 0.001\n  - -0.002\n  - 0.0\n";
  EXPECT_THAT(ErrorOf("camera_matrix:\n" + rows + d),
              AllOf(HasSubstr("size of the pictures is missing"), HasSubstr("image_width: W")));
  for (const char* size :
       {"image_size: [640, 480]\n", "image_size:\n- 640\n- 480\n", "resolution: [640, 480]\n",
        "img_size: {width: 640, height: 480}\n", "width: 640\nheight: 480\n", "imageSize: [ 640, 480 ]\n",
        "image_Width: 640\nimage_Height: 480\n"})
    ExpectLens(Read("camera_matrix:\n" + rows + d + size), Radial());
  ExpectLens(Read("<?xml version=\"1.0\"?><opencv_storage><image_size>\n640 480</image_size><mtx "
                  "type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt><data>600.5 0 320.5 0 "
                  "601.25 239.25 0 0 "
                  "1</data></mtx><dist "
                  "type_id=\"opencv-matrix\"><rows>1</rows><cols>5</cols><dt>d</dt><data>-0.1 0.05 "
                  "0.001 -0.002 0</data></dist></opencv_storage>"),
             Radial());
  // Open3D's columns first; its file has no distortion.
  const ReadLens turned = Read(
      "{\"width\": 640, \"height\": 480, \"intrinsic_matrix\": [600.5, 0, 0, 0, 601.25, 0, 320.5, 239.25, "
      "1]}");
  EXPECT_EQ(turned.lens.camera.cx, 321);
  EXPECT_EQ(turned.lens.camera.fy, 601.25);
  EXPECT_THAT(turned.lens.warnings, ElementsAre(HasSubstr("columns first"), HasSubstr("without distortion")));
  // Arrays' order of the sides.
  EXPECT_THAT(Read("camera_matrix:\n" + rows + d + "image_size: [480, 640]\n").lens.warnings,
              ElementsAre(HasSubstr("width and height exchanged")));
  EXPECT_THAT(Read("camera_matrix:\n" + rows + d + "image_size: [320, 240]\n").lens.warnings,
              ElementsAre(HasSubstr("outside the picture of 320x240")));
}

TEST(LensFiles, ChoosesTheNamedOneOfTwoCameras) {
  const std::string other = "[612.5, 0, 318.5, 0, 613.25, 241.25, 0, 0, 1]",
                    d5 = "[-0.1, 0.05, 0.001, -0.002, 0]";
  const std::string size = "image_size: [640, 480]\n";
  struct Case {
    std::string text, names, first;
  };
  for (const Case& c : {
           Case{fmt::format("M1: {}\nD1: {}\nM2: {}\nD2: {}\n", kK, d5, other, d5), "(1, 2)", "1"},
           Case{fmt::format("K2: {}\nD2: {}\nK1: {}\nD1: {}\n", other, d5, kK, d5), "(2, 1)", "1"},
           Case{fmt::format("cameraMatrixL: {}\ndistCoeffsL: {}\ncameraMatrixR: {}\ndistCoeffsR: {}\n", kK,
                            d5, other, d5),
                "(l, r)", "L"},
           Case{fmt::format(
                    "left_camera_matrix: {}\nleft_distortion_coefficients: {}\nright_camera_matrix: {}\n"
                    "right_distortion_coefficients: {}\n",
                    kK, d5, other, d5),
                "(left, right)", "left"},
           Case{fmt::format("left:\n  K: {}\n  D: {}\nright:\n  K: {}\n  D: {}\n", kK, d5, other, d5),
                "(left, right)", "left"},
           Case{fmt::format("cameras:\n- K: {}\n  D: {}\n- K: {}\n  D: {}\n", kK, d5, other, d5),
                "(cameras.1, cameras.2)", "cameras.1"},
       }) {
    EXPECT_THAT(ErrorOf(c.text + size), AllOf(HasSubstr(c.names), HasSubstr("ulf calibration")));
    ExpectLens(Read(c.text + size, c.first), Radial());
    EXPECT_THAT(ErrorOf(c.text, c.first), HasSubstr("size of the pictures is missing"));
    EXPECT_THAT(ErrorOf(c.text + size, "third"), HasSubstr("no camera 'third'"));
  }
  // Each has its own word.
  const std::string two = fmt::format(
      "K1: {}\nD1: {}\nK2: {}\nD2: {}\ndistortion_model1: equidistant\n"
      "distortion_model2: plumb_bob\n",
      kK, kFisheyeD, kK, d5);
  ExpectLens(Read(two + size, "1"), Fisheye());
  ExpectLens(Read(two + size, "2"), Radial());
}

// OpenCV itself writes the file, in each of its three syntaxes, and itself says where a point is seen.
TEST(LensFiles, PointsAreWhereOpenCvSeesThem) {
  const cv::Matx33d k(600.5, 0, 320.5, 0, 601.25, 239.25, 0, 0, 1);
  const std::vector<double> radial = {-0.1, 0.05, 0.001, -0.002, 0.02},
                            fisheye = {-0.01, 0.002, -0.003, 0.0004};
  const std::vector<cv::Point3d> points = {{0, 0, 1}, {0.5, 0.35, 1}, {-0.5, 0.3, 1}, {0.1, -0.4, 1}};
  for (const char* ending : {".yml", ".xml", ".json"})
    for (const bool is_fisheye : {false, true}) {
      const std::vector<double>& d = is_fisheye ? fisheye : radial;
      cv::FileStorage file(ending, cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
      file << "calibration_time"
           << "Thu 21 Mar 2024: noon"
           << "nr_of_frames" << 12 << "image_width" << 640 << "image_height" << 480 << "flags"
           << (is_fisheye ? 10 : 0) << "fisheye_model" << (is_fisheye ? 1 : 0) << "camera_matrix"
           << cv::Mat(k) << "distortion_coefficients" << cv::Mat(d, true) << "per_view_errors"
           << cv::Mat(cv::Mat::ones(12, 1, CV_32F)) << "name" << std::vector<std::string>{"a: b", "[c"};
      const std::string text = file.releaseAndGetString();
      SCOPED_TRACE(text);
      const CameraModel camera = Read(text).lens.camera;
      std::vector<cv::Point2d> seen;
      const cv::Vec3d none(0, 0, 0);
      if (is_fisheye)
        cv::fisheye::projectPoints(points, seen, none, none, k, d);
      else
        cv::projectPoints(points, none, none, k, d, seen);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const auto ours = camera.ImgFromCam({points[i].x, points[i].y, points[i].z});
        ASSERT_TRUE(ours);
        EXPECT_NEAR(ours->x(), seen[i].x + 0.5, 1e-9);
        EXPECT_NEAR(ours->y(), seen[i].y + 0.5, 1e-9);
      }
    }
}

TEST(LensFiles, TheCommandSaysWhatWasTaken) {
  const test::ScratchFolder scratch;
  const auto path = scratch / "pair.yml";
  std::ofstream(path) << "\xEF\xBB\xBF" << OpenCvYaml("", kRadialD);
  const auto warned = test::RunUlf("calibration " + path.string());
  EXPECT_EQ(warned.exit_code, 0);
  EXPECT_THAT(warned.errors, AllOf(HasSubstr("pair.yml"), HasSubstr("fisheye_model: 1")));
  EXPECT_THAT(warned.output, HasSubstr("k1 k2 p1 p2 k3 -0.1 0.05 0.001 -0.002 0"));
  EXPECT_THAT(ReadCalibrationFile(path).warnings, ElementsAre(HasSubstr("four coefficients")));
  std::ofstream(path) << OpenCvYaml("distortion_model: equidistant\n", kFisheyeD);
  const auto said = test::RunUlf("calibration " + path.string());
  EXPECT_THAT(said.errors, IsEmpty());
  EXPECT_THAT(said.output, HasSubstr("fisheye        -0.01 0.002 -0.003 0.0004"));
}

// The page's table is the list that messages have.
TEST(LensFiles, ThePageNamesEveryProgram) {
  std::stringstream page;
  page << std::ifstream(std::string(CHECKOUT) + "/docs/calibration.md").rdbuf();
  for (const std::string& program : ReadableLensPrograms())
    EXPECT_THAT(page.str(), HasSubstr("| " + program + " |"));
  for (const std::string& program : ReadableLensPrograms())
    EXPECT_THAT(ReadableLensFiles(), HasSubstr(program));
  // What is wrong comes first, and stays in sight.
  EXPECT_LT(ReadableLensFiles().size(), 200u);
}

}  // namespace
}  // namespace ulf::lens_files_test
