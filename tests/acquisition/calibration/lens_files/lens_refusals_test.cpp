// Tests: acquisition/calibration/lens_files/lens_files, acquisition/calibration/lens_files/lens_numbers,
// acquisition/calibration/lens_files/lens_words,
// acquisition/calibration/lens_files/lens_tree.
//
// What is refused, or taken with a warning: by its own name, with the way out.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>

#include "acquisition/calibration/lens_files/lens_files.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::lens_refusals_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

struct LensOfTest {
  std::string size = "image_width: 640\nimage_height: 480\n";
  std::string k = "600, 0, 320, 0, 601, 240, 0, 0, 1";
  int k_rows = 3, k_cols = 3;
  std::string words = "";
  std::string d = "-0.1, 0.05, 0.001, -0.002, 0";
  int d_rows = 1, d_cols = 5;

  std::string Text() const {
    return fmt::format(
        "%YAML:1.0\n---\n{}camera_matrix: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} "
        "]\n{}"
        "distortion_coefficients: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n",
        size, k_rows, k_cols, k, words, d_rows, d_cols, d);
  }
};

std::string ErrorOf(const std::string& text) {
  try {
    if (!ReadLensText(text, "the file")) return "not recognised";
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(LensRefusals, NameUnsupportedModelsInEveryFormat) {
  for (const char* word :
       {"omnidirectional", "mei", "ds", "double_sphere", "eucm", "fov", "division", "ftheta", "f-theta",
        "scaramuzza", "thin_prism", "inverse_brown_conrady", "equisolid", "cahvor"})
    for (const std::string& text :
         {LensOfTest{.words = fmt::format("distortion_model: {}\n", word)}.Text(),
          LensOfTest{.words = fmt::format("camera_model: {}\n", word)}.Text(),
          LensOfTest{.words = fmt::format("model: {}\n", word)}.Text(),
          LensOfTest{.words = fmt::format("type: \"{}\"\n", word)}.Text(),
          fmt::format("cam0:\n  camera_model: {}\n  intrinsics: [0.6, 500, 500, 320, 240]\n", word),
          fmt::format("model_type: {}\nprojection_parameters:\n   gamma1: 600\n", word),
          fmt::format("Camera.type: \"{}\"\nCamera.fx: 600\n", word),
          fmt::format("{{\"value0\": {{\"intrinsics\": [{{\"camera_type\": \"{}\", \"intrinsics\": {{}}}}], "
                      "\"resolution\": "
                      "[[640, 480]]}}}}",
                      word)})
      EXPECT_THAT(ErrorOf(text), AllOf(HasSubstr("the file"), HasSubstr(fmt::format("'{}'", word)),
                                       HasSubstr("is not one of ulf's"), HasSubstr("calibrate again"),
                                       HasSubstr("pinhole-equi")))
          << text;
  // Unknown words are no models to be guessed at, unless they stand where a maker's may stand.
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "distortion_model: wobbly\n"}.Text()),
              AllOf(HasSubstr("'wobbly'"), HasSubstr("unknown"), HasSubstr("delete the line")));
  EXPECT_EQ(ErrorOf(LensOfTest{.words = "model: acA1300-60gm\ntype: camera\n"}.Text()), "accepted");
  // A key of another model says as much as its word.
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "xi: 0.9\n"}.Text()),
              AllOf(HasSubstr("'xi'"), HasSubstr("omnidirectional")));
  EXPECT_THAT(ErrorOf("{\"Calibration\": {\"cameras\": [{\"model\": {\"polymorphic_id\": 2147483649, "
                      "\"polymorphic_name\": "
                      "\"libCalib::CameraModelKannalaBrandt\"}}]}}"),
              AllOf(HasSubstr("libCalib::CameraModelKannalaBrandt"), HasSubstr("OpenCV model")));
}

TEST(LensRefusals, NameModelsThatContradictEachOther) {
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "distortion_model: plumb_bob\nfisheye_model: 1\n"}.Text()),
              AllOf(HasSubstr("distortion_model: plumb_bob"), HasSubstr("fisheye_model: 1"),
                    HasSubstr("contradict")));
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "fisheye_model: 0\ndistortion_model: equidistant\n"}.Text()),
              HasSubstr("contradict"));
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "distortion_model: none\n"}.Text()),
              HasSubstr("without distortion"));
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "width: 641\nheight: 480\n"}.Text()),
              AllOf(HasSubstr("'image_width' and 'width'"), HasSubstr("different values")));
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "K: [600, 0, 321, 0, 601, 240, 0, 0, 1]\n"}.Text()),
              HasSubstr("'camera_matrix' and 'K'"));
  EXPECT_EQ(ErrorOf(LensOfTest{.words = "width: 640.\nheight: 480\nskew: 0\n"}.Text()), "accepted");
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "skew: 0.25\n"}.Text()), HasSubstr("'skew' is 0.25"));
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "fisheye_model: maybe\n"}.Text()), HasSubstr("must be 1 or 0"));
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "image_width: 641\n"}.Text()),
              AllOf(HasSubstr("image_width"), HasSubstr("twice")));
  // OpenCV's flags: 8 is without p1 and p2, or a fisheye's fixed skew; 16384 is a rational model.
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "flags: 10\n"}.Text()),
              AllOf(HasSubstr("CALIB_ZERO_TANGENT_DIST"), HasSubstr("fisheye_model: 1")));
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "flags: 16384\n"}.Text()), HasSubstr("8 coefficients"));
  EXPECT_EQ(ErrorOf(LensOfTest{.words = "flags: 10\n", .d = "-0.1, 0.05, 0, 0, 0.2"}.Text()), "accepted");
}

TEST(LensRefusals, NameCountsThatContradictTheNumbers) {
  struct Case {
    LensOfTest lens;
    std::string_view mentioned;
  };
  const std::string fisheye = "distortion_model: equidistant\n", plumb_bob = "distortion_model: plumb_bob\n";
  for (const Case& c : {
           Case{{.k = "600, 0, 320, 0, 601, 240, 0, 0"}, "3 x 3 values, but 8"},
           Case{{.k_rows = 3, .k_cols = 4}, "3 x 4 values, but 9"},
           Case{{.k = "600, 0, 320, 0, 0, 601, 240, 0, 0, 0, 1, 0", .k_cols = 4}, "no 3x3 camera matrix"},
           Case{{.d_cols = 4}, "1 x 4 values, but 5"},
           Case{{.d_rows = 5}, "5 x 5 values, but 5"},
           Case{{.d = "0.1, 0.2, 0.3, 0.4", .d_rows = 2, .d_cols = 2}, "one row or one column"},
           Case{{.words = fisheye, .d = "0.1, 0.2, 0.3, 0.4, 0.5"}, "has 4 coefficients, but there are 5"},
           Case{{.words = fisheye, .d = "0.1, 0.2, 0.3", .d_cols = 3}, "has 4 coefficients, but there are 3"},
           Case{{.words = fisheye, .d = "", .d_cols = 0}, "has 4 coefficients, but there are 0"},
           Case{{.words = plumb_bob, .d = "0.1, 0.2, 0.3, 0.4, 0.5, 0.6", .d_cols = 6},
                "4 or 5 coefficients, but there are 6"},
           Case{{.words = plumb_bob, .d = "0.1, 0.2", .d_cols = 2}, "4 or 5 coefficients, but there are 2"},
           Case{{.words = "distortion_model: rational_polynomial\n"}, "a rational model has 8, 12 or 14"},
           Case{{.d = "0.1, 0.2, 0.3, 0.4, 0.5, 0.6", .d_cols = 6}, "6 coefficients"},
           Case{{.d = "1, 2, 3, 4, 5, 6, 7, 8", .d_cols = 8}, "CALIB_RATIONAL_MODEL"},
           Case{{.size = "image_width: 0\nimage_height: 0\n"}, "0x0"},
           Case{{.size = "image_width: -640\nimage_height: 480\n"}, "-640 x 480"},
           Case{{.size = "image_width: 640.5\nimage_height: 480\n"}, "640.5 x 480"},
           Case{{.size = "image_width: wide\nimage_height: 480\n"}, "'wide'"},
           Case{{.size = "image_size: [640, 480, 3]\n"}, "two numbers"},
           Case{{.size = ""}, "size of the pictures is missing"},
           Case{{.k = "600, 0.5, 320, 0, 601, 240, 0, 0, 1"}, "skew (0.5)"},
           Case{{.k = "600, 0, 320, 0, 601, 240, 0, 0, 2"}, "last row"},
           Case{{.k = "600, 0, 320, 0, 601, 240, 0.1, 0, 1"}, "last row"},
           Case{{.k = "600, 0, 320, 3, 601, 240, 0, 0, 1"}, "below its first focal length"},
           Case{{.k = "-600, 0, 320, 0, 601, 240, 0, 0, 1"}, "must be positive"},
           Case{{.k = ".Nan, 0, 320, 0, 601, 240, 0, 0, 1"}, "not finite"},
           Case{{.d = "0.1, .Nan, 0, 0, 0"}, "not finite"},
           Case{{.d = "0.1, -.Inf, 0, 0, 0"}, "not finite"},
           Case{{.d = "0.1, much, 0, 0, 0"}, "numbers alone"},
           Case{{.k = "0, 0, 0, 0, 0, 0, 0, 0, 0"}, "not calibrated"},
           Case{{.k = "0.94, 0, 0.5, 0, 1.25, 0.5, 0, 0, 1"}, "no lens has that"},
           Case{{.k = "8, 0, 320, 0, 8, 240, 0, 0, 1"}, "millimetres"},
       })
    EXPECT_THAT(ErrorOf(c.lens.Text()), AllOf(HasSubstr("the file"), HasSubstr(std::string(c.mentioned))))
        << c.lens.Text();
  EXPECT_THAT(
      ErrorOf("cam0:\n  camera_model: pinhole\n  intrinsics: [500, 500, 320]\n  distortion_model: radtan\n"
              "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [640, 480]\n"),
      HasSubstr("4 intrinsics, not 3"));
  EXPECT_THAT(ErrorOf("{\"value0\": {\"intrinsics\": [{\"camera_type\": \"kb4\", \"intrinsics\": {}}], "
                      "\"resolution\": []}}"),
              HasSubstr("1 cameras, but 0 sizes"));
  // Distortion in a form that would be passed over.
  for (const char* form :
       {"distortion: {k1: 0.1}\n", "k1: 0.1\nk2: 0.2\n", "distortion_in_words: [0.1, 0.2]\n"})
    EXPECT_THAT(
        ErrorOf(fmt::format("image_size: [640, 480]\nK: [600, 0, 320, 0, 601, 240, 0, 0, 1]\n{}", form)),
        HasSubstr("in a form that ulf does not read"))
        << form;
}

TEST(LensRefusals, OtherProgramsAreNamed) {
  using namespace std::string_literals;
  struct Case {
    std::string text, program, way_out;
  };
  for (const Case& c : {
           Case{"# camera model\n{ 'lensmodel': 'LENSMODEL_OPENCV8', 'intrinsics': [600] }\n", "mrcal",
                "mrcal-convert-lensmodel"},
           Case{"<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:li stCamera:Make=\"A\"/></x:xmpmeta>", "Adobe",
                "ulf calibrate"},
           Case{"#polynomial coefficients for the DIRECT mapping function\n\n5 -1 0 0 0 0\n", "OCamCalib",
                "pinhole-equi"},
           Case{"ParGroup: Cam1: Internal parameters:\n", "HALCON", "OpenCV"},
           Case{"sensor_msgs.msg.CameraInfo(header=std_msgs.msg.Header(\n", "ROS", "ros2 topic echo"},
           Case{"Calibration results\n====\nCamera-system parameters:\ncam0 (/cam0):\n", "Kalibr",
                "camchain"},
           Case{"Intrinsic of \"Color\" / 640x480 / {RGB8}\n  Width: 640\n", "RealSense", "camera_matrix"},
           Case{"[LEFT_CAM_HD]\nfx=700\n", "ZED", "camera_matrix"},
           Case{"fc = [ 657 ; 657 ];\ncc = [ 302 ; 242 ];\n", "MATLAB", "camera_matrix"},
           Case{"RadTan 600 600 320 240 0 0 0 0\n640 480\ncrop\n640 480\n", "DSO", "camera_matrix"},
           Case{"\x1f\x8b\x08\0\0"s, "gzip", "ost.yaml"},
           Case{"\xff\xfeK\0:\0"s, "16 bits", "UTF-8"},
           Case{"PK\x03\x04\x14\0"s, "NumPy", "camera_matrix"},
           Case{"MATLAB 5.0 MAT-file", "MATLAB", "cameraIntrinsicsToOpenCV"},
           Case{"\x01\0\0\0\0\0\0\0"s, "no text", "colmap model_converter"},
           Case{"{\"priors\": [{\"CameraIntrinsicsPrior\": {}}]}", "Theia", "camera_matrix"},
           Case{"{\"sfm_data_version\": \"0.3\", \"views\": []}", "OpenMVG", "cameras.txt"},
           Case{"{\"version\": [], \"views\": [], \"intrinsics\": []}", "AliceVision", "cameras.txt"},
           Case{"{\"v2 maker\": {\"projection_type\": \"brown\", \"width\": 640, \"focal_x\": 0.9}}",
                "OpenSfM", "export_colmap"},
           Case{"{\"IntrinsicMatrix\": [[600, 0, 0], [0, 600, 0], [320, 240, 1]], \"RadialDistortion\": [0, "
                "0]}",
                "MATLAB", "cameraIntrinsicsToOpenCV"},
           Case{"{\"CalibrationInformation\": {}}", "Azure Kinect", "ulf calibrate"},
           Case{"target_type: 'aprilgrid'\ntagCols: 6\n", "target", "camchain"},
           Case{"rostopic: /imu0\naccelerometer_noise_density: 0.01\n", "inertial", "camera's file"},
           Case{"%YAML:1.0\nimu: 1\ncam0_calib: \"cam0_mei.yaml\"\n", "VINS", "cam0_calib"},
           Case{"%YAML:1.0\nR1: [1]\nP1: [1]\nR2: [1]\nP2: [1]\nQ: [1]\n", "rectification", "intrinsics.yml"},
           Case{"<?xml "
                "version=\"1.0\"?><opencv_storage><Settings><Calibrate_Pattern>\"CHESSBOARD\"</"
                "Calibrate_Pattern>"
                "</Settings></opencv_storage>",
                "settings", "Write_outputFileName"},
           Case{"<?xml version=\"1.0\"?><document><chunk/></document>", "Metashape", "ulf import"},
           Case{"<calibration><fx>600</fx><fy>600</fy></calibration>", "PhotoScan",
                "save the calibration again"},
           Case{"P0: 718.8 0 607.2 0 0 718.8 185.2 0 0 0 1 0\nP1: 718.8 0 607.2 -386.1 0 718.8 185.2 0 0 0 1 "
                "0\n"
                "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n",
                "KITTI", "first three columns"},
           Case{"fisheye_params: [300, 300, 320, 240, 0.1, 0, 0, 0]\n", "'fisheye_params'",
                "distortion_model: equidistant"},
           Case{"cam:\n  fisheye_params: {fx: 300, k1: 0.1}\n", "'fisheye_params'",
                "distortion_model: equidistant"},
           Case{"<x:xmpmeta><rdf:Description xcr:DistortionModel=\"brown3\" "
                "xcr:FocalLength35mm=\"24\"/></x:xmpmeta>",
                "RealityScan", "ulf import"},
           Case{"#name,x,y,alt,heading,pitch,roll,f,px,py,k1\n", "RealityScan", "ulf import"},
           Case{"NVM_V3\n\n1\n", "VisualSFM", "cameras.txt"},
           Case{"# Bundle file v0.3\n1 0\n600 0.1 0.2\n", "Bundler", "camera_matrix"},
           Case{"<lensdatabase><lens/></lensdatabase>", "lensfun", "ulf calibrate"},
           Case{"<rig><camera_model type=\"calibu_fu_fv_u0_v0_w\"/></rig>", "Calibu", "camera_matrix"},
           Case{"<ExportAPERO><CalibrationInternConique/></ExportAPERO>", "MicMac", "camera_matrix"},
           Case{"<BlocksExchange version=\"2.1\"/>", "BlocksExchange", "cameras.txt"},
           Case{"<Cameras><KeyFrame VICON_RADIAL=\"632 520 0 0\"/></Cameras>", "Vicon", "camera_matrix"},
           Case{"Pix4D camera calibration file 0\nF 15.0\n", "Pix4D", "camera_matrix"},
           Case{"0.349 0.437 0.493 0.499 0.933\n1280 1024\ncrop\n640 480\n", "field-of-view",
                "pinhole-radtan"},
           Case{"[camera]\nfocal_length = 0.88\npixel_aspect = 1\nprincipal_point = 0.5 0.5\n", "MVE",
                "camera_matrix"},
           Case{"{\"cameraData\": [[0, {\"cameraType\": 0, \"width\": 640, \"height\": 480, "
                "\"intrinsicMatrix\": "
                "[[600, 0, 320], [0, 600, 240], [0, 0, 1]], \"distortionCoeff\": [0, 0, 0, 0, 0]}]]}",
                "DepthAI", "camera_matrix"},
           Case{"{\"sfm_data_version\": \"0.3\", \"intrinsics\": [{\"value\": {\"data\": {\"width\": 640, "
                "\"focal_length\": [600, 600], \"principal_point\": [320, 240]}}}]}",
                "OpenMVG", "cameras.txt"},
           Case{"{\"FocalLength\": [600, 600], \"PrincipalPoint\": [321, 241], \"ImageSize\": [480, 640]}",
                "MATLAB", "cameraIntrinsicsToOpenCV"},
           Case{"{\"fl_x\": 600, \"w\": 640, \"h\": 480, \"ftheta_p0\": 0.1}", "instant-ngp", "undistort"},
           Case{"shutter: 5\ngain: 3\n", "(its keys are 'shutter', 'gain')", "Kalibr"},
           Case{"<?xml version=\"1.0\"?><nothing/>", "no lens that ulf knows", "Kalibr"},
       }) {
    EXPECT_THAT(ErrorOf(c.text), AllOf(HasSubstr("the file"), HasSubstr(c.program), HasSubstr(c.way_out)))
        << c.text;
  }
  // What is wrong is the first sentence; what follows is the one list.
  EXPECT_THAT(ErrorOf("shutter: 5\n"),
              ::testing::StartsWith("the file: holds no lens that ulf knows: neither a camera "
                                    "matrix nor fx, fy, cx and cy (its keys are 'shutter'). "));
  EXPECT_THAT(ErrorOf("shutter: 5\n"), HasSubstr(ReadableLensFiles()));
  EXPECT_THAT(ErrorOf("[LEFT_CAM_HD]\nfx=700\n"), HasSubstr(ReadableLensFiles()));
  for (const char* text : {"words without any form\n", "import cv2\nprint(\"a: b\")\nx = [1\n",
                           "# Title\n\nSome text: with colon\n- item\n"})
    EXPECT_EQ(ErrorOf(text), "not recognised") << text;
}

const std::string kFourOfTest = "-0.01, 0.002, -0.003, 0.0004";

std::string WithWords(const std::string& words) {
  return LensOfTest{.words = words, .d = kFourOfTest, .d_cols = 4}.Text();
}

TEST(LensRefusals, WordsUnderOtherKeysAreNotPassedOver) {
  const auto expect_refused = [](const std::string& text, const std::string& quoted) {
    EXPECT_THAT(ErrorOf(text),
                AllOf(HasSubstr("the file: '" + quoted), HasSubstr("distortion_model: equidistant"),
                      HasSubstr("distortion_model: plumb_bob")))
        << text;
  };
  struct Case {
    std::string words, quoted;
  };
  for (const Case& c : {Case{"calibration_type: fisheye\n", "calibration_type: fisheye'"},
                        Case{"type: \"fisheye lens\"\n", "type: fisheye lens'"},
                        Case{"lens:\n  type: fisheye\n", "type: fisheye'"},
                        Case{"lens: { model: \"Fish-Eye, 8 mm\" }\n", "model: Fish-Eye, 8 mm'"},
                        Case{"flags: \"+fix_skew+fisheye\"\n", "flags: +fix_skew+fisheye'"},
                        Case{"flags: [fix_skew, fisheye]\n", "flags: fisheye'"},
                        Case{"camera_lens: fisheye\n", "camera_lens: fisheye'"},
                        Case{"method: cv::fisheye::calibrate\n", "method: cv::fisheye::calibrate'"},
                        Case{"calib_model_name: Kannala/Brandt\n", "calib_model_name: Kannala/Brandt'"},
                        Case{"kind: EQUIDISTANT\n", "kind: EQUIDISTANT'"},
                        Case{"calibration_type: omni-directional\n", "calibration_type: omni-directional'"},
                        Case{"camera_is_fisheye: 1\n", "camera_is_fisheye: 1'"},
                        Case{"fisheye_params: [0.1, 0.2, 0.3, 0.4]\n", "fisheye_params: ...'"}}) {
    expect_refused(WithWords(c.words), c.quoted);
    // The way out.
    for (const char* model : {"equidistant", "plumb_bob"})
      EXPECT_EQ(ErrorOf(WithWords(c.words + "distortion_model: " + model + "\n")), "accepted") << c.words;
  }
  const auto xml = [](const std::string& words) {
    return "<?xml version=\"1.0\"?><opencv_storage><image_width>640</image_width><image_height>480"
           "</image_height><camera_matrix><rows>3</rows><cols>3</cols><data>600 0 320 0 601 240 0 0 1</data>"
           "</camera_matrix>" +
           words +
           "<dist_coeffs><rows>1</rows><cols>4</cols><data>-0.01 0.002 -0.003 0.0004</data></dist_coeffs>"
           "</opencv_storage>";
  };
  expect_refused(xml("<lens><model>fisheye</model></lens>"), "model: fisheye'");
  expect_refused(
      "{\"info\": {\"optics\": \"fisheye\"}, \"w\": 640, \"h\": 480, \"K\": [[600, 0, 320], [0, 601, "
      "240], [0, 0, 1]], \"D\": [-0.01, 0.002, -0.003, 0.0004]}",
      "optics: fisheye'");
  EXPECT_THAT(ErrorOf("Camera.fx: 600\nCamera.fy: 600\nCamera.cx: 320\nCamera.cy: 240\nCamera.width: "
                      "640\nCamera.height: 480\nCamera.lens: fisheye\n"),
              AllOf(HasSubstr("'Camera.lens: fisheye'"), HasSubstr("KannalaBrandt8")));
}

TEST(LensRefusals, NamesThatSpeakOfFisheyesAreWarnings) {
  const auto warnings_of = [](const std::string& text, const std::string& camera = "") {
    return ReadLensText(text, "the file", camera)->lens.warnings;
  };
  for (const char* line : {"image_topic: /fisheye/image", "camera_name: fisheye_left", "frame_id: fisheye",
                           "images: /data/fisheye/*.png", "source: fisheye_07.bag", "camera_id: omni_2",
                           "model_file: fisheye.yaml"}) {
    const std::string text = WithWords(std::string(line) + "\n");
    EXPECT_EQ(ErrorOf(text), "accepted");
    EXPECT_THAT(warnings_of(text), ::testing::Contains(AllOf(HasSubstr(fmt::format("'{}'", line)),
                                                             HasSubstr("distortion_model: equidistant"))));
    EXPECT_THAT(warnings_of(WithWords(std::string(line) + "\ndistortion_model: plumb_bob\n")),
                ::testing::IsEmpty());
  }
  for (const char* line :
       {"sensor: OmniVision OV9281", "fisheye_model: 0", "lens: {fisheye: 0}", "fisheye_left_T: [1, 0, 0, 1]",
        "fisheye_T: [[1, 0], [0, 1]]", "pattern: asymmetric"})
    EXPECT_THAT(ErrorOf(WithWords(std::string(line) + "\n")), "accepted") << line;
  // A word decides; text that speaks of another model is told.
  EXPECT_THAT(warnings_of(WithWords("camera_lens: fisheye\ndistortion_model: plumb_bob\n")),
              ::testing::ElementsAre(
                  AllOf(HasSubstr("'camera_lens: fisheye'"), HasSubstr("'distortion_model: plumb_bob'"))));
  EXPECT_THAT(warnings_of(WithWords("camera_lens: fisheye\ndistortion_model: equidistant\n")),
              ::testing::IsEmpty());
  // Of the chosen camera alone.
  const std::string numbers =
      "K: [[600, 0, 320], [0, 601, 240], [0, 0, 1]], D: [-0.01, 0.002, -0.003, 0.0004], w: 640, h: 480";
  const std::string two = "tele: {" + numbers + "}\nwide: {optics: fisheye, " + numbers + "}\n";
  EXPECT_THAT(warnings_of(two, "tele"), ::testing::ElementsAre(HasSubstr("four coefficients")));
  EXPECT_THROW(ReadLensText(two, "the file", "wide"), Error);
  const std::string pair =
      "K1: [600, 0, 320, 0, 601, 240, 0, 0, 1]\nD1: [-0.1, 0.05, 0.001, -0.002]\n"
      "K2: [600, 0, 320, 0, 601, 240, 0, 0, 1]\nD2: [-0.1, 0.05, 0.001, -0.002]\n"
      "optics2: fisheye\nimage_width: 640\nimage_height: 480\n";
  EXPECT_THAT(warnings_of(pair, "1"), ::testing::ElementsAre(HasSubstr("four coefficients")));
  EXPECT_THROW(ReadLensText(pair, "the file", "2"), Error);
}

TEST(LensRefusals, CutFilesAreNoLensesWithoutDistortion) {
  const std::string whole = LensOfTest{}.Text();
  const std::size_t at = whole.find("distortion_coefficients: !!ope");
  for (const char* end : {"distortion_coefficients: !!ope", "distortion_coefficients: !!opencv-matrix\n",
                          "distortion_coefficients:"})
    EXPECT_THAT(ErrorOf(whole.substr(0, at) + end),
                AllOf(HasSubstr("nothing stands behind 'distortion_coefficients'"), HasSubstr("may be cut")));
  const std::string ost =
      "[image]\n\nwidth\n640\n\nheight\n480\n\n[narrow_stereo]\n\ncamera matrix\n"
      "600.0 0.0 320.0\n0.0 601.0 240.0\n0.0 0.0 1.0\n\ndistortion\n";
  EXPECT_THAT(ErrorOf(ost), HasSubstr("nothing stands behind 'distortion'"));
  EXPECT_EQ(ErrorOf(ost + "0.1 -0.2 0.001 -0.002 0.0\n"), "accepted");
  EXPECT_THAT(ErrorOf("[cam_0]\nname = \"a\"\nsize = [ 640, 480,]\n"
                      "matrix = [ [ 600.0, 0.0, 320.0,], [ 0.0, 601.0, 240.0,], [ 0.0, 0.0, 1.0,],]\ndist"),
              HasSubstr("nothing stands behind 'dist'"));
  EXPECT_THAT(ErrorOf("label: cam0\nimage_height: 480\nimage_width: 640\ntype: pinhole\n"
                      "line-delay-nanoseconds: 0\nintrinsics:\n  cols: 1\n  rows: 4\n"
                      "  data: [600, 601, 320, 240]\n"),
              AllOf(HasSubstr("'distortion' is missing"), HasSubstr("type: none")));
  // What ORB-SLAM3 and stella_vslam take without coefficients is said.
  const char* numbers = "fx: 600\n{0}fy: 601\n{0}cx: 320\n{0}cy: 240\n";
  for (const std::string& text :
       {"Camera.type: \"PinHole\"\nCamera1." + fmt::format(fmt::runtime(numbers), "Camera1.") +
            "Camera.width: 640\nCamera.height: 480\n",
        "Camera:\n  model: perspective\n  " + fmt::format(fmt::runtime(numbers), "  ") +
            "  cols: 640\n  rows: 480\n"}) {
    const auto read = ReadLensText(text, "the file");
    ASSERT_TRUE(read) << text;
    EXPECT_THAT(read->lens.warnings, ::testing::ElementsAre(HasSubstr("holds no distortion coefficients")));
  }
  // A message of ROS cut in its matrix, or before it.
  const std::string head =
      "header:\n  frame_id: c\nheight: 480\nwidth: 640\ndistortion_model: plumb_bob\nd:\n";
  EXPECT_THAT(ErrorOf(head + "- 0.1\nk:\n- 600.0\n- 0.0\n- 320.0\n- 0.0\n"),
              HasSubstr("'k' has 4 of 9 values"));
  EXPECT_THAT(ErrorOf(head), HasSubstr("'k' has 0 of 9 values"));
}

TEST(LensRefusals, NumbersThatHardlyAnyLensHasAreSaid) {
  const auto warnings_of = [](const std::string& text) {
    const auto read = ReadLensText(text, "the file");
    return read ? read->lens.warnings : std::vector<std::string>{"not recognised"};
  };
  const auto kalibr = [](const std::string& intrinsics, const std::string& size) {
    return fmt::format(
        "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [-0.1, 0.05, 0.001, -0.002]\n"
        "  distortion_model: radtan\n  intrinsics: [{}]\n  resolution: {}\n",
        intrinsics, size);
  };
  // By hand: 0.1 of 640 and 480 are 64 and 48 px; pixels are counted from the middle of the first.
  EXPECT_THAT(warnings_of(kalibr("600, 601, 383, 240", "[640, 480]")), ::testing::IsEmpty());
  EXPECT_THAT(warnings_of(kalibr("600, 601, 320, 240", "640x480")), ::testing::IsEmpty());
  EXPECT_THAT(
      warnings_of(kalibr("600, 601, 384, 240", "[640, 480]")),
      ::testing::ElementsAre(AllOf(HasSubstr("(384.5, 240.5) is 10 % of the width and 0 % of the height"),
                                   HasSubstr("hardly any lens"))));
  EXPECT_THAT(warnings_of(kalibr("600, 601, 320, 2.5", "[640, 480]")),
              ::testing::ElementsAre(HasSubstr("0 % of the width and 49 % of the height")));
  // Another size; and the numbers in another order, cx cy fx fy.
  EXPECT_THAT(warnings_of(kalibr("600, 601, 320, 240", "[1280, 960]")),
              ::testing::ElementsAre(HasSubstr("middle of pictures of 1280x960")));
  EXPECT_THAT(
      warnings_of(kalibr("320, 240, 600, 400", "[640, 480]")),
      ::testing::ElementsAre(HasSubstr("principal point"), HasSubstr("320 and 240 px, differ by 33 %")));
  EXPECT_THAT(warnings_of("1 PINHOLE 640 480 600 730 320 240\n"),
              ::testing::ElementsAre(HasSubstr("differ by 22 %")));
  EXPECT_THAT(warnings_of("1 PINHOLE 640 480 600 710 320 240\n"), ::testing::IsEmpty());
}

TEST(LensRefusals, NameContradictingDuplicates) {
  const std::string json = "{{\"w\": 640, \"h\": 480, \"fl_x\": 600, {}\"cx\": 320, \"cy\": 240}}";
  const auto with = [&](const char* more) { return fmt::format(fmt::runtime(json), more); };
  EXPECT_EQ(ErrorOf(with("")), "accepted");
  EXPECT_THAT(ErrorOf(with("\"fl_x\": 700, ")),
              AllOf(HasSubstr("'fl_x' is there twice"), HasSubstr("delete")));
  // By hand: an angle of 2 atan(320 / 600) is 0.98096; 1.2 is a focal length of 467.7 px.
  EXPECT_EQ(ErrorOf(with("\"camera_angle_x\": 0.98096, ")), "accepted");
  EXPECT_THAT(
      ErrorOf(with("\"camera_angle_x\": 1.2, ")),
      AllOf(HasSubstr("'fl_x' says a focal length of 600"), HasSubstr("'camera_angle_x' one of 467.7")));
  EXPECT_THAT(ErrorOf(LensOfTest{.words = "fx: 600\nfx: 700\n"}.Text()), HasSubstr("'fx' is there twice"));
  EXPECT_EQ(ErrorOf(LensOfTest{.words = "fx: 600.4\nfy: 601\ncx: 320.5\ncy: 240.5\n"}.Text()), "accepted");
  EXPECT_THAT(
      ErrorOf(LensOfTest{.words = "fx: 700\n"}.Text()),
      AllOf(HasSubstr("'fx: 700' stands beside 'camera_matrix', which has 600"), HasSubstr("delete")));
  const std::string row = "1 PINHOLE 640 480 600 600 320 240\n";
  EXPECT_EQ(ErrorOf(row + row), "accepted");
  EXPECT_THAT(ErrorOf(row + "1 PINHOLE 640 480 500 500 320 240\n"), HasSubstr("camera 1 is there twice"));
  EXPECT_THAT(ErrorOf("1 PINHOLE 640 480 nan 500 320 240\n"),
              HasSubstr("'nan' is no number that a lens has"));
}

TEST(LensRefusals, DamagedTextIsNamedByItsLine) {
  EXPECT_THAT(ErrorOf("cam0:\n  intrinsics: [500, 500\n"),
              AllOf(HasSubstr("the file, line"), HasSubstr("YAML")));
  EXPECT_THAT(ErrorOf("{\"K\": [1, 2"), AllOf(HasSubstr("the file"), HasSubstr("JSON")));
  EXPECT_THAT(ErrorOf("<?xml version=\"1.0\"?>\n<calibration>\n<f>6"),
              AllOf(HasSubstr("the file, line 3"), HasSubstr("XML")));
  // A text that refers to itself must not become a tree without end.
  std::string growing = "intrinsics: 1\na0: &a0 [1, 1]\n";
  for (int i = 1; i < 11; ++i) growing += fmt::format("a{0}: &a{0} [*a{1}, *a{1}, *a{1}, *a{1}]\n", i, i - 1);
  EXPECT_THAT(ErrorOf(growing), HasSubstr("too many values"));
}

TEST(LensRefusals, PicturesAndFoldersAreNamed) {
  const test::ScratchFolder scratch;
  const auto picture = scratch / "photo.png";
  cv::imwrite(picture.string(), cv::Mat(16, 16, CV_8U, cv::Scalar(90)));
  EXPECT_THAT(
      test::RunUlf("calibration " + picture.string()).errors,
      AllOf(HasSubstr("is a picture"), HasSubstr("ulf calibrate FOLDER"), Not(HasSubstr("COLMAP's"))));
  EXPECT_THAT(test::RunUlf("calibration " + scratch.path().string()).errors,
              AllOf(HasSubstr("is a folder"), Not(HasSubstr("no such"))));
}

TEST(LensRefusals, CommandListsModelsAndWritesNothing) {
  const test::ScratchFolder scratch;
  const auto path = scratch / "notes.txt", out = scratch / "camera.json";
  WriteFileAtomically(path, "words without any form\n");
  for (const std::string& more : {std::string(), " -o " + out.string()}) {
    const auto result = test::RunUlf("calibration " + path.string() + more);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.errors, AllOf(HasSubstr("notes.txt"), HasSubstr("Lenses of ulf"), HasSubstr("ROS"),
                                     Not(HasSubstr("neither JSON nor numbers"))));
  }
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace ulf::lens_refusals_test
