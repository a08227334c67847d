// Tests: acquisition/calibration/lens_files/lens_numbers, acquisition/calibration/lens_files/marked_keys,
// acquisition/calibration/lens_files/matrix_files, acquisition/calibration/lens_files/lens_tree.
//
// What scripts and small programs write: sizes under many words, lenses without a matrix, ini, TOML and
// attributes of XML; and files that were cut.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>

#include "tests/acquisition/calibration/lens_files/lens_texts.h"

namespace ulf::lens_scripts_test {
namespace {

using namespace lens_texts;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kFive = "[-0.1, 0.05, 0.001, -0.002, 0]";

std::string WithSize(const std::string& size, const std::string& k = kK) {
  return fmt::format("{{\"K\": {}, \"D\": {}, {}}}", k, kFive, size);
}

TEST(LensScripts, ReadTheSizeUnderManyNames) {
  for (const char* size :
       {"\"DIM\": [640, 480]", "\"dim\": {\"w\": 640, \"h\": 480}",
        "\"calib_dimension\": {\"w\": 640, \"h\": 480}", "\"image_dimension\": [640, 480]",
        "\"frame_size\": [640, 480]", "\"width_px\": 640, \"height_px\": 480", "\"resolution\": \"640x480\"",
        "\"resolution\": \"640 x 480\"", "\"image_size\": \"(640, 480)\"",
        "\"resolution_x\": 640, \"resolution_y\": 480", "\"image\": {\"width\": 640, \"height\": 480}",
        "\"resolution\": {\"x\": 640, \"y\": 480}", "\"img_size\": {\"width\": 640, \"height\": 480}",
        "\"image_shape\": [480, 640]", "\"img_shape\": [480, 640, 3]", "\"shape\": [480, 640]"}) {
    const ReadLens read = Read(WithSize(size));
    ExpectLens(read, Radial());
    EXPECT_THAT(read.lens.warnings, IsEmpty()) << size;
  }
  ExpectLens(Read(fmt::format("K: {}\nD: {}\nresolution: 640x480\n", kK, kFive)), Radial());
}

// NumPy has the height first; some scripts turn the shape around under the same name. The
// principal point tells.
TEST(LensScripts, PrincipalPointTellsTheOrderOfAShape) {
  const ReadLens turned = Read(WithSize("\"image_shape\": [640, 480]"));
  ExpectLens(turned, Radial());
  EXPECT_THAT(turned.lens.warnings,
              ElementsAre(AllOf(HasSubstr("'image_shape: 640, 480'"), HasSubstr("width and height"))));
  const std::string between = "[600.5, 0, 281, 0, 601.25, 279, 0, 0, 1]";
  EXPECT_THAT(
      ErrorOf(WithSize("\"image_shape\": [480, 640]", between)),
      AllOf(HasSubstr("'image_shape: 480, 640'"), HasSubstr("tells neither"), HasSubstr("image_width: W")));
  // Three numbers are an array's, whatever the lens; so are those of a square.
  EXPECT_EQ(Read(WithSize("\"image_shape\": [480, 640, 3]", between)).lens.camera.width, 640);
  EXPECT_EQ(Read(WithSize("\"image_shape\": [560, 560]", between)).lens.camera.height, 560);
}

std::string CutRos(const std::string& rest) {
  return fmt::format(
      "image_width: 640\nimage_height: 480\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: {}\n{}",
      kK, rest);
}

TEST(LensScripts, AFileThatIsCutBehindItsMatrixIsRefused) {
  for (const std::string& text :
       {CutRos(""), CutRos("distortion_model: plumb_bob\n"),
        CutRos("distortion_model: plumb_bob\ndistortion_coefficients:\n"),
        fmt::format("%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   "
                    "rows: 3\n"
                    "   cols: 3\n   dt: d\n   data: {}\n",
                    kK),
        fmt::format("image_size: [640, 480]\nmtx: {}\n", kK),
        std::string("[image]\nwidth\n640\nheight\n480\n[narrow_stereo]\ncamera matrix\n600.5 0 320.5\n0 "
                    "601.25 239.25\n"
                    "0 0 1\n"),
        std::string(
            "model_type: PINHOLE\nimage_width: 640\nimage_height: 480\nprojection_parameters:\n   fx: 600.5\n"
            "   fy: 601.25\n   cx: 320.5\n   cy: 239.25\n")})
    EXPECT_THAT(ErrorOf(text), AllOf(HasSubstr("the file"), HasSubstr("may be cut"),
                                     HasSubstr("rite it again"), HasSubstr("distortion")))
        << text;
  EXPECT_THAT(ErrorOf(CutRos("distortion_model: plumb_bob\n")),
              HasSubstr("for 'distortion_model: plumb_bob'"));
  EXPECT_THAT(
      ErrorOf("Camera.fx: 600.5\nCamera.fy: 601.25\nCamera.cx: 320.5\nCamera.cy: 239.25\nCamera.k1: 0.1\n"
              "Camera.width: 640\nCamera.height: 480\n"),
      HasSubstr("'Camera.k2' is missing"));
  // What says that there is none, and text that closes what it opens.
  for (const std::string& text :
       {CutRos("distortion_model: plumb_bob\nD: []\n"), CutRos("distortion_model: ''\nD: []\nR: []\nP: []\n"),
        CutRos("distortion_model: none\n"), CutRos("distortion_coefficients: [0, 0, 0, 0, 0]\n"),
        fmt::format("{{\"K\": {}, \"width\": 640, \"height\": 480}}", kK)})
    EXPECT_EQ(Read(text).lens.camera.distortion, Distortion::kNone) << text;
}

TEST(LensScripts, ReadLensesWithoutAMatrix) {
  const std::string pinhole =
                        "\"fx\": 600.5, \"fy\": 601.25, \"cx\": 320.5, \"cy\": 239.25, \"width\": 640, "
                        "\"height\": 480",
                    intel =
                        "\"fx\": 600.5, \"fy\": 601.25, \"ppx\": 320.5, \"ppy\": 239.25, \"width\": 640, "
                        "\"height\": 480, \"model\": \"distortion.";
  const ReadLens plain = Read("{" + pinhole + ", \"t_00\": 1, \"blur_score\": 40}");
  EXPECT_EQ(plain.lens.camera, (CameraModel{640, 480, 600.5, 601.25, 321, 239.75, Distortion::kNone, {}}));
  EXPECT_THAT(plain.lens.warnings, ElementsAre(HasSubstr("without distortion")));
  EXPECT_EQ(
      Read("cam:\n  H: 480\n  W: 640\n  fx: 600.5\n  fy: 601.25\n  cx: 320.5\n  cy: 239.25\n").lens.camera,
      plain.lens.camera);
  // RealSense names this model also where there is nothing to model.
  EXPECT_EQ(
      Read("{\"color\": {" + intel + "inverse_brown_conrady\", \"coeffs\": [0, 0, 0, 0, 0]}}").lens.camera,
      plain.lens.camera);
  EXPECT_THAT(ErrorOf("{" + intel + "inverse_brown_conrady\", \"coeffs\": [0.1, 0, 0, 0, 0]}"),
              HasSubstr("is not one of ulf's"));
  ExpectLens(Read("{" + intel + "brown_conrady\", \"coeffs\": " + kFive + "}"), Radial());
  ExpectLens(Read("{" + intel + "kannala_brandt4\", \"coeffs\": " + kFisheyeD + "}"), Fisheye());
  // Keys k1, ... say nothing without the model's word.
  const std::string keys = "\"k1\": -0.1, \"k2\": 0.05, \"p1\": 0.001, \"p2\": -0.002",
                    four = "\"k1\": -0.01, \"k2\": 0.002, \"k3\": -0.003, \"k4\": 0.0004";
  EXPECT_THAT(ErrorOf("{" + pinhole + ", " + keys + "}"),
              AllOf(HasSubstr("plumb_bob"), HasSubstr("equidistant")));
  ExpectLens(Read("{\"camera_model\": \"radtan\", " + pinhole + ", " + keys + "}"), Radial());
  ExpectLens(Read("{\"camera_model\": \"fisheye\", " + pinhole + ", \"distortion\": {" + four + "}}"),
             Fisheye());
  EXPECT_THAT(ErrorOf("{\"camera_model\": \"fisheye\", " + pinhole + ", " + four + ", \"p1\": 0.1}"),
              AllOf(HasSubstr("'p1' is 0.1"), HasSubstr("camera_model: fisheye")));
  ExpectLens(Read(fmt::format("{{\"camera_matrix\": {{{}}}, \"dist_coeffs\": {}}}", pinhole, kFive)),
             Radial());
  ExpectLens(
      Read(
          "<rig><camera fx=\"600.5\" fy=\"601.25\" cx=\"320.5\" cy=\"239.25\" width=\"640\" height=\"480\" "
          "model=\"radtan\"><distortion k1=\"-0.1\" k2=\"0.05\" p1=\"0.001\" p2=\"-0.002\"/></camera></rig>"),
      Radial());
}

// The matrix of A2D2's that belongs to the coefficients.
TEST(LensScripts, TheMatrixOfPicturesAsTaken) {
  ExpectLens(
      Read(fmt::format(
          "{{\"cameras\": {{\"front\": {{\"Lens\": \"Telecam\", \"CamMatrix\": [[580, 0, 320], [0, 580, "
          "240], [0, 0, 1]], \"CamMatrixOriginal\": {}, \"Distortion\": [{}], \"Resolution\": [640, "
          "480]}}}}}}",
          kK, kFive)),
      Radial());
}

TEST(LensScripts, IniAndTomlAreRead) {
  const auto camera = [](const char* name, const char* d, const char* more) {
    return fmt::format(
        "[{}]\nname = \"A # 1\"  # the first\nsize = [ 640, 480,]\nmatrix = [ [ 600.5, 0.0, 320.5,],\n"
        "  [ 0.0, 601.25, 239.25,],\n  [ 0.0, 0.0, 1.0,],]\ndistortions = {}\nrotation = [ 0.1, 0.2, "
        "0.3,]\n{}\n",
        name, d, more);
  };
  const std::string two = camera("cam_0", kFive, "") + camera("cam_1", kFisheyeD, "fisheye = true\n") +
                          "[metadata]\nadjusted = true\nerror = 0.3\n";
  ExpectLens(Read(two, "cam_0"), Radial());
  ExpectLens(Read(two, "1"), Fisheye());
  EXPECT_THAT(ErrorOf(two), HasSubstr("2 cameras (cam_0, cam_1)"));
  ExpectLens(Read(camera("cam_1", kRadialD, "fisheye = false\n")), Radial());
  EXPECT_EQ(
      Read("[camera]\nfx = 600.5 ; pixels\nfy = 601.25\ncx = 320.5\ncy = 239.25\nwidth = 640\nheight = 480\n")
          .lens.camera.fy,
      601.25);
  const std::string pair =
      "cam0=[600.5 0 320.5; 0 601.25 239.25; 0 0 1]\ncam1=[600.5 0 330.5; 0 601.25 239.25; 0 0 1]\n"
      "doffs=10\nbaseline=193.001\nwidth=640\nheight=480\nndisp=280\n";
  EXPECT_EQ(Read(pair, "1").lens.camera.cx, 331);
  EXPECT_EQ(Read(pair, "cam0").lens.camera.distortion, Distortion::kNone);
  EXPECT_THAT(ErrorOf("[camera]\nmatrix = [ [ 600.5, 0.0,\n"),
              AllOf(HasSubstr("'matrix'"), HasSubstr("may be cut")));
}

TEST(LensScripts, PartsOfThePictureAreNoPixels) {
  for (const std::string& text :
       {std::string("{\"fl_x\": 600, \"fl_y\": 600, \"cx\": 0.5, \"cy\": 0.5, \"w\": 640, \"h\": 480}"),
        std::string("1 PINHOLE 640 480 600 600 0.5 0.5\n"),
        std::string(
            "{\"fx\": 600, \"fy\": 600, \"cx\": -0.01, \"cy\": 0.02, \"width\": 640, \"height\": 480}"),
        std::string(
            "{\"K\": [[600, 0, 0], [0, 600, 0], [0, 0, 1]], \"D\": [], \"width\": 640, \"height\": 480}")})
    EXPECT_THAT(ErrorOf(text), AllOf(HasSubstr("corner of pictures of 640x480"),
                                     HasSubstr("parts of the picture"), HasSubstr("320 240")))
        << text;
  EXPECT_THAT(ErrorOf("1 PINHOLE 640 480 0.9 1.2 320 240\n"), HasSubstr("no lens has that"));
  const auto warnings_of = [](double f) {
    return Read(fmt::format("1 PINHOLE 640 480 {} {} 320 240\n", f, f)).lens.warnings;
  };
  EXPECT_THAT(warnings_of(100), ElementsAre(HasSubstr("without a fisheye")));
  EXPECT_THAT(warnings_of(90000), ElementsAre(HasSubstr("telescope")));
  EXPECT_THAT(warnings_of(170), IsEmpty());
  EXPECT_THAT(Read("1 OPENCV_FISHEYE 640 480 100 100 320 240 0 0 0 0\n").lens.warnings, IsEmpty());
}

TEST(LensScripts, AFisheyeHasNoTangentialDistortion) {
  const std::string lens =
      "{\"camera_model\": \"OPENCV_FISHEYE\", \"fl_x\": 600.5, \"fl_y\": 601.25, \"cx\": 321, "
      "\"cy\": 239.75, \"w\": 640, \"h\": 480, \"k1\": -0.01, \"k2\": 0.002, \"k3\": -0.003, "
      "\"k4\": 0.0004, \"p1\": ";
  EXPECT_THAT(
      ErrorOf(lens + "0.001, \"p2\": 0}"),
      AllOf(HasSubstr("'p1' and 'p2' are 0.001 and 0"), HasSubstr("OPENCV_FISHEYE"), HasSubstr("undistort")));
  ExpectLens(Read(lens + "0, \"p2\": 0}"), Fisheye());
  EXPECT_THAT(
      ErrorOf("Camera.type: \"KannalaBrandt8\"\nCamera.fx: 600\nCamera.fy: 600\nCamera.cx: 320\nCamera.cy: "
              "240\nCamera.k1: 0.1\nCamera.k2: 0\nCamera.k3: 0\nCamera.k4: 0\nCamera.p1: 0.1\nCamera.width: "
              "640\nCamera.height: 480\n"),
      HasSubstr("'Camera.p1' does not belong to a fisheye"));
}

TEST(LensScripts, ACameraIsNamedByNumberNameOrTopic) {
  const auto camera = [](const char* name, const char* d, const char* model) {
    return fmt::format(
        "{0}:\n  camera_model: pinhole\n  distortion_coeffs: {1}\n  distortion_model: {2}\n  intrinsics: "
        "[600.5, 601.25, 320.5, 239.25]\n  resolution: [640, 480]\n  rostopic: /{0}/image_raw\n",
        name, d, model);
  };
  const std::string chain = camera("cam0", kRadialD, "radtan") + camera("cam1", kFisheyeD, "equidistant");
  for (const char* first : {"0", "cam0", "CAM0", "/cam0/image_raw", "camera 0"})
    ExpectLens(Read(chain, first), Radial());
  for (const char* second : {"1", "cam1", "/cam1/image_raw"}) ExpectLens(Read(chain, second), Fisheye());
  EXPECT_THAT(ErrorOf(chain), HasSubstr("2 cameras (cam0 /cam0/image_raw, cam1 /cam1/image_raw)"));
  EXPECT_THAT(ErrorOf(chain, "2"), AllOf(HasSubstr("no camera '2'"), HasSubstr("cam1 /cam1/image_raw")));
  const std::string one = camera("cam0", kRadialD, "radtan");
  ExpectLens(Read(one, "0"), Radial());
  EXPECT_THAT(ErrorOf(WithSize("\"size\": [640, 480]"), "cam3"), HasSubstr("contains only one camera"));
  // Pictures that all have the same lens are of one camera.
  const std::string same = fmt::format("{{\"K\": {}, \"D\": {}, \"size\": [640, 480]}}", kK, kFive);
  ExpectLens(Read("{\"pictures\": [" + same + ", " + same + ", " + same + "]}"), Radial());
}

TEST(LensScripts, GyroflowIsRead) {
  const auto profile = [](const std::string& more, const std::string& d = kFisheyeD) {
    return fmt::format(
        "{{\"name\": \"A\", \"camera_brand\": \"A\", \"camera_model\": \"HERO9 Black\", \"lens_model\": "
        "\"Wide\", "
        "\"calib_dimension\": {{\"w\": 640, \"h\": 480}}, \"orig_dimension\": {{\"w\": 1280, \"h\": 960}}, "
        "\"fisheye_params\": {{\"RMS_error\": 0.5, \"camera_matrix\": [[600.5, 0, 320.5], [0, 601.25, "
        "239.25], [0, 0, "
        "1]], \"distortion_coeffs\": {}, \"radial_distortion_limit\": null}}, {} \"calibrator_version\": "
        "\"1\"}}",
        d, more);
  };
  const ReadLens read = Read(profile(""));
  ExpectLens(read, Fisheye());
  EXPECT_EQ(read.program, "Gyroflow");
  EXPECT_THAT(read.lens.warnings, IsEmpty());
  ExpectLens(Read(profile("\"distortion_model\": \"opencv_fisheye\", \"digital_lens\": null, "
                          "\"input_horizontal_stretch\": 1.0,")),
             Fisheye());
  ExpectLens(Read(profile("\"distortion_model\": \"opencv_standard\",", kFive)), Radial());
  EXPECT_THAT(ErrorOf(profile("\"distortion_model\": \"poly5\",")), HasSubstr("'poly5'"));
  EXPECT_THAT(ErrorOf(profile("\"digital_lens\": \"gopro_superview\",")),
              HasSubstr("digital_lens: gopro_superview"));
  EXPECT_THAT(ErrorOf(profile("\"input_horizontal_stretch\": 1.33,")),
              HasSubstr("input_horizontal_stretch: 1.33"));
}

TEST(LensScripts, OkvisAndMcCalibAreRead) {
  const auto okvis = [](const char* d, const char* type) {
    return fmt::format(
        "  - {{T_SC: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], image_dimension: [640, 480],\n"
        "     distortion_coefficients: {}, distortion_type: {},\n"
        "     focal_length: [600.5, 601.25], principal_point: [320.5, 239.25]}}\n",
        d, type);
  };
  const std::string pair = "%YAML:1.0\ncameras:\n" + okvis(kRadialD, "radialtangential") +
                           okvis(kFisheyeD, "equidistant") + "camera_params:\n    camera_rate: 20\n";
  ExpectLens(Read(pair, "0"), Radial());
  ExpectLens(Read(pair, "1"), Fisheye());
  EXPECT_EQ(Read(pair, "1").program, "okvis");
  ExpectLens(Read("cameras:\n" + okvis("[-0.1, 0.05, 0.001, -0.002, 0, 0, 0, 0]", "radialtangential8")),
             Radial());
  EXPECT_THAT(
      ErrorOf("cameras:\n" + okvis("[-0.1, 0.05, 0.001, -0.002, 0.1, 0.1, 0, 0]", "radialtangential8")),
      HasSubstr("rational"));
  // Brown is 0, Kannala's model 1.
  const auto mc_calib = [](const char* d, int count, int type) {
    return fmt::format(
        "camera_{3}:\n   camera_matrix:\n      rows: 3\n      cols: 3\n      data: {0}\n"
        "   distortion_vector:\n      rows: 1\n      cols: {2}\n      data: {1}\n   distortion_type: {3}\n"
        "   img_width: 640\n   img_height: 480\n",
        kK, d, count, type);
  };
  const std::string group =
      "%YAML:1.0\n---\nnb_camera: 2\n" + mc_calib(kFive, 5, 0) + mc_calib(kFisheyeD, 4, 1);
  ExpectLens(Read(group, "camera_0"), Radial());
  ExpectLens(Read(group, "1"), Fisheye());
}

}  // namespace
}  // namespace ulf::lens_scripts_test
