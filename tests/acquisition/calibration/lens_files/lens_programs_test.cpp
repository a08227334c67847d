// Tests: acquisition/calibration/lens_files/program_files, acquisition/calibration/lens_files/set_files.
//
// What is read of single programs, each by a text written here, with the numbers that it must give.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "tests/acquisition/calibration/lens_files/lens_texts.h"

namespace ulf::lens_programs_test {
namespace {

using namespace lens_texts;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

TEST(LensPrograms, KalibrAndEurocAreRead) {
  const std::string four = "[600.5, 601.25, 320.5, 239.25]";
  const auto camera = [&](const std::string& indent, const char* model, const char* d, const char* key) {
    return fmt::format(
        "{0}camera_model: pinhole\n{0}intrinsics: {1}\n{0}distortion_model: {2}\n{0}{4}: {3}\n"
        "{0}resolution: [640, 480]\n",
        indent, four, model, d, key);
  };
  const std::string chain = "%YAML:1.0\ncam0:\n" + camera("  ", "radtan", kRadialD, "distortion_coeffs") +
                            "cam1:\n" + camera("  ", "equidistant", kFisheyeD, "distortion_coeffs");
  ExpectLens(Read(chain, "cam0"), Radial());
  ExpectLens(Read(chain, "cam1"), Fisheye());
  const std::string sensor =
      "sensor_type: camera\ncomment: VI-Sensor cam0\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, "
      "0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: 20\n";
  const ReadLens euroc = Read(sensor + camera("", "radial-tangential", kRadialD, "distortion_coefficients"));
  ExpectLens(euroc, Radial());
  EXPECT_EQ(euroc.program, "EuRoC");
  ExpectLens(Read(sensor + camera("", "equidistant", kFisheyeD, "distortion_coefficients")), Fisheye());
}

TEST(LensPrograms, MaplabIsRead) {
  struct Camera {
    std::string label, type, parameters;
    int count = 4;
    std::string projection = "pinhole";
    int intrinsics = 4;
  };
  const auto text = [](const Camera& c, const std::string& indent) {
    return fmt::format(
        "{0}label: {1}\n{0}distortion:\n{0}  parameters:\n{0}    cols: 1\n{0}    rows: {4}\n{0}    data: "
        "{3}\n"
        "{0}  type: {2}\n{0}image_height: 480\n{0}image_width: 640\n{0}intrinsics:\n{0}  cols: 1\n"
        "{0}  rows: {6}\n{0}  data: [{7}600.5, 601.25, 320.5, 239.25]\n{0}line-delay-nanoseconds: 0\n"
        "{0}type: {5}\n",
        indent, c.label, c.type, c.parameters, c.count, c.projection, c.intrinsics,
        c.intrinsics == 5 ? "0.9, " : "");
  };
  const auto rig = [&](const std::vector<Camera>& cameras) {
    std::string made = "label: rig\nid: 0123\ncameras:\n";
    for (const Camera& camera : cameras)
      made +=
          "- T_B_C:\n    cols: 4\n    rows: 4\n    data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
          "  camera:\n" +
          text(camera, "    ");
    return made;
  };
  const Camera equidistant{"cam0", "equidistant", kFisheyeD}, radial{"cam1", "radial-tangential", kRadialD};
  const ReadLens one = Read(rig({equidistant}));
  ExpectLens(one, Fisheye());
  EXPECT_EQ(one.program, "maplab");
  EXPECT_THAT(one.lens.warnings, IsEmpty());
  ExpectLens(Read(rig({radial})), Radial());
  ExpectLens(Read(text(radial, "")), Radial());
  ExpectLens(Read(rig({equidistant, radial}), "cam0"), Fisheye());
  ExpectLens(Read(rig({equidistant, radial}), "cam1"), Radial());
  EXPECT_THAT(ErrorOf(rig({equidistant, radial})), HasSubstr("2 cameras (cam0, cam1)"));
  EXPECT_THAT(
      ErrorOf(fmt::format("image_width: 640\nimage_height: 480\nintrinsics: {{rows: 3, cols: 3, data: {}}}\n"
                          "distortion: {{type: plumb_bob, values: {}}}\n",
                          kK, kRadialD)),
      AllOf(HasSubstr("'distortion'"), Not(HasSubstr("maplab"))));
  // Labels that are the same are numbers.
  Camera same = radial;
  same.label = "cam0";
  ExpectLens(Read(rig({equidistant, same}), "1"), Radial());
  EXPECT_EQ(Read(text({"c", "none", "[]", 0}, "")).lens.camera.distortion, Distortion::kNone);
  EXPECT_THAT(ErrorOf(rig({{"cam0", "fisheye", "[0.9]", 1}})),
              AllOf(HasSubstr("'fisheye' of maplab, the field-of-view model"), HasSubstr("pinhole-equi")));
  EXPECT_THAT(ErrorOf(rig({{"cam0", "rational-tangential", "[0, 0, 0, 0, 0, 0, 0, 0]", 8}})),
              AllOf(HasSubstr("'rational-tangential' of maplab"), HasSubstr("pinhole-radtan")));
  EXPECT_THAT(ErrorOf(rig({{"cam0", "radial-tangential", kRadialD, 4, "unified-projection", 5}})),
              AllOf(HasSubstr("'unified-projection' of maplab"), HasSubstr("pinhole-radtan")));
  EXPECT_THAT(ErrorOf(rig({{"cam0", "equidistant", "[0.1, 0.2]", 2}})), HasSubstr("has 4 coefficients"));
  EXPECT_THAT(ErrorOf(rig({{"cam0", "equidistant", kFisheyeD, 5}})), HasSubstr("'parameters'"));
}

TEST(LensPrograms, OrbSlamIsRead) {
  const auto settings = [](const char* camera, const char* type, const char* more) {
    return fmt::format(
        "%YAML:1.0\n\n#----\n# Camera\nCamera.type: \"{1}\"\n{0}.fx: 600.5\n{0}.fy: 601.25\n{0}.cx: 320.5\n"
        "{0}.cy: 239.25\n{2}Camera.width: 640\nCamera.height: 480\nCamera.fps: 30.0\n",
        camera, type, more);
  };
  const ReadLens second = Read(settings(
      "Camera", "PinHole", "Camera.k1 : -0.1\nCamera.k2: 0.05\nCamera.p1: 0.001\nCamera.p2: -0.002\n"));
  ExpectLens(second, Radial());
  EXPECT_EQ(second.program, "ORB-SLAM");
  EXPECT_THAT(second.lens.warnings, IsEmpty());
  const std::string k3 =
      "Camera1.k1: -0.1\nCamera1.k2: 0.05\nCamera1.p1: 0.001\nCamera1.p2: -0.002\nCamera1.k3: 0.25\n";
  ExpectLens(Read("File.version: \"1.0\"\n" + settings("Camera1", "PinHole", k3.c_str())), Radial(0.25));
  const char* fisheye = "Camera1.k1: -0.01\nCamera1.k2: 0.002\nCamera1.k3: -0.003\nCamera1.k4: 0.0004\n";
  ExpectLens(Read(settings("Camera1", "KannalaBrandt8", fisheye)), Fisheye());
  EXPECT_THAT(ErrorOf(settings("Camera1", "PinHole", fisheye)), HasSubstr("Camera1.k4"));
  // OpenVSLAM's and stella_vslam's.
  const char* kb = "  k1: -0.01\n  k2: 0.002\n  k3: -0.003\n  k4: 0.0004\n";
  const auto nested = [&](const char* model) {
    return fmt::format(
        "Camera:\n  name: cam\n  setup: monocular\n  model: {}\n  fx: 600.5\n  fy: 601.25\n  cx: 320.5\n"
        "  cy: 239.25\n{}  cols: 640\n  rows: 480\n",
        model, kb);
  };
  ExpectLens(Read(nested("fisheye")), Fisheye());
  EXPECT_THAT(ErrorOf(nested("perspective")), HasSubstr("Camera.k4"));
  EXPECT_THAT(ErrorOf(nested("equirectangular")), HasSubstr("'equirectangular'"));
  ExpectLens(
      Read("Camera.model: \"perspective\"\nCamera.fx: 600.5\nCamera.fy: 601.25\nCamera.cx: 320.5\nCamera.cy: "
           "239.25\nCamera.k1: -0.1\nCamera.k2: 0.05\nCamera.p1: 0.001\nCamera.p2: -0.002\nCamera.k3: "
           "0.25\nCamera.cols: 640\nCamera.rows: 480\n"),
      Radial(0.25));
  // The stereo pair of ORB-SLAM2: what remains after rectifying, and the two lenses.
  const std::string pair = settings("Camera", "PinHole", "") +
                           fmt::format(
                               "LEFT.height: 480\nLEFT.width: 640\nLEFT.D: !!opencv-matrix\n   rows: "
                               "1\n   cols: 5\n   dt: d\n   data:[-0.1, 0.05, 0.001, -0.002, "
                               "0.0]\nLEFT.K: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
                               "   data: {0}\nRIGHT.K: {0}\nRIGHT.D: {1}\n",
                               kK, kRadialD);
  EXPECT_THAT(ErrorOf(pair), HasSubstr("(Camera, LEFT, RIGHT)"));
  ExpectLens(Read(pair, "left"), Radial());
  EXPECT_EQ(Read(pair, "Camera").lens.camera.distortion, Distortion::kNone);
}

TEST(LensPrograms, VinsIsRead) {
  const auto file = [](const char* model, const char* distortion, const char* projection) {
    return fmt::format(
        "%YAML:1.0\n---\nmodel_type: {}\ncamera_name: cam\nimage_width: 640\nimage_height: 480\n"
        "distortion_parameters:\n{}projection_parameters:\n{}",
        model, distortion, projection);
  };
  const char* pinhole = "   fx: 600.5\n   fy: 601.25\n   cx: 320.5\n   cy: 239.25\n";
  const char* fisheye = "   mu: 600.5\n   mv: 601.25\n   u0: 320.5\n   v0: 239.25\n";
  const std::string powers = "   k2: -0.01\n   k3: 0.002\n   k4: -0.003\n   k5: 0.0004\n";
  ExpectLens(Read(file("PINHOLE", "   k1: -0.1\n   k2: 0.05\n   p1: 0.001\n   p2: -0.002\n", pinhole)),
             Radial());
  ExpectLens(Read(file("KANNALA_BRANDT", "", (powers + fisheye).c_str())), Fisheye());
  ExpectLens(Read(file("KANNALA_BRANDT", powers.c_str(), fisheye)), Fisheye());
  EXPECT_THAT(ErrorOf(file("KANNALA_BRANDT", "", fisheye)), HasSubstr("'k2'"));
  EXPECT_THAT(
      ErrorOf(file("KANNALA_BRANDT", "   k2: 1\n   k3: 0\n   k4: 0\n   k5: 0\n", (powers + fisheye).c_str())),
      HasSubstr("differ"));
}

TEST(LensPrograms, BasaltAndCalibIoAreRead) {
  const auto basalt = [](const std::string& type, const std::string& more) {
    return fmt::format(
        "{{\"value0\": {{\"T_imu_cam\": [], \"intrinsics\": [{{\"camera_type\": \"{}\", \"intrinsics\": "
        "{{\"fx\": 600.5, \"fy\": 601.25, \"cx\": 320.5, \"cy\": 239.25{}}}}}], \"resolution\": [[640, "
        "480]], \"vignette\": []}}}}",
        type, more);
  };
  ExpectLens(Read(basalt("kb4", ", \"k1\": -0.01, \"k2\": 0.002, \"k3\": -0.003, \"k4\": 0.0004")),
             Fisheye());
  ExpectLens(Read(basalt("pinhole-radtan8",
                         ", \"k1\": -0.1, \"k2\": 0.05, \"p1\": 0.001, \"p2\": -0.002, \"k3\": 0.25, "
                         "\"k4\": 0, \"k5\": 0, \"k6\": 0, \"rpmax\": 2.5")),
             Radial(0.25));
  EXPECT_EQ(Read(basalt("pinhole", "")).lens.camera.distortion, Distortion::kNone);

  // fy is f times the ratio; the second camera of a kind has the kind's number alone.
  const auto camera = [](const std::string& kind, double cx) {
    return fmt::format(
        "{{\"model\": {{{}, \"ptr_wrapper\": {{\"valid\": 1, \"data\": {{\"parameters\": {{\"f\": {{\"val\": "
        "600.5}}, \"ar\": {{\"val\": 1.0012489592006661}}, \"cx\": {{\"val\": {}}}, \"cy\": {{\"val\": "
        "239.25}}, \"k1\": {{\"val\": -0.1}}, \"k2\": {{\"val\": 0.05}}, \"k3\": {{\"val\": 0.25}}, "
        "\"p1\": {{\"val\": 0.001}}, \"p2\": {{\"val\": -0.002}}}}, \"CameraModelCRT\": "
        "{{\"CameraModelBase\": {{\"imageSize\": {{\"width\": 640, \"height\": 480}}}}}}}}}}}}}}",
        kind, cx);
  };
  const std::string opencv =
      "\"polymorphic_id\": 2147483649, \"polymorphic_name\": \"libCalib::CameraModelOpenCV\"";
  const std::string one = fmt::format("{{\"Calibration\": {{\"cameras\": [{}]}}}}", camera(opencv, 320.5));
  ExpectLens(Read(one), Radial(0.25));
  const std::string two = fmt::format("{{\"Calibration\": {{\"cameras\": [{}, {}]}}}}", camera(opencv, 320.5),
                                      camera("\"polymorphic_id\": 1", 330.5));
  EXPECT_THAT(ErrorOf(two), HasSubstr("2 cameras (0, 1)"));
  EXPECT_EQ(Read(two, "1").lens.camera.cx, 331);
}

// By Agisoft's formulas: u = w/2 + cx + x' (f + b1), v = h/2 + cy + y' f, with the middle of the first pixel
// at one half; x' has P1 (r² + 2x²) + 2 P2 x y, where OpenCV's has 2 p1 x y + p2 (r² + 2x²).
TEST(LensPrograms, MetashapeIsRead) {
  const auto file = [](const char* projection, const char* more) {
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<calibration>\n  <projection>{}</projection>\n"
        "  <width>640</width>\n  <height>480</height>\n  <f>601.25</f>\n  <cx>1</cx>\n  <cy>-0.25</cy>\n"
        "  <b1>-0.75</b1>\n{}  <date>2024-03-05T10:11:12Z</date>\n</calibration>\n",
        projection, more);
  };
  const ReadLens frame = Read(file(
      "frame", "  <k1>-0.1</k1>\n  <k2>0.05</k2>\n  <k3>0.25</k3>\n  <p1>-0.002</p1>\n  <p2>0.001</p2>\n"));
  ExpectLens(frame, Radial(0.25));
  EXPECT_THAT(frame.lens.warnings, IsEmpty());
  ExpectLens(Read(file("fisheye", "<k1>-0.01</k1><k2>0.002</k2><k3>-0.003</k3><k4>0.0004</k4>")), Fisheye());
  const double x = 0.3, y = -0.2, r2 = x * x + y * y,
               radial = 1 - 0.1 * r2 + 0.05 * r2 * r2 + 0.25 * r2 * r2 * r2;
  const auto seen = frame.lens.camera.ImgFromCam({x, y, 1});
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->x(), 320 + 1 + 600.5 * (x * radial - 0.002 * (r2 + 2 * x * x) + 2 * 0.001 * x * y), 1e-9);
  EXPECT_NEAR(seen->y(), 240 - 0.25 + 601.25 * (y * radial + 0.001 * (r2 + 2 * y * y) - 2 * 0.002 * x * y),
              1e-9);
  EXPECT_THAT(ErrorOf(file("frame", "<b2>0.5</b2>")), AllOf(HasSubstr("b2"), HasSubstr("Optimize")));
  EXPECT_THAT(ErrorOf(file("fisheye", "<p1>0.5</p1>")), HasSubstr("p1"));
  for (const char* projection : {"spherical", "equisolid_fisheye", "cylindrical"})
    EXPECT_THAT(ErrorOf(file(projection, "")), HasSubstr(projection));
}

TEST(LensPrograms, SetsOfPhotographsAreRead) {
  const std::string lens =
      "\"w\": 640, \"h\": 480, \"fl_x\": 600.5, \"fl_y\": 601.25, \"cx\": 321, \"cy\": 239.75";
  const std::string radial = ", \"k1\": -0.1, \"k2\": 0.05, \"p1\": 0.001, \"p2\": -0.002",
                    fisheye = ", \"k1\": -0.01, \"k2\": 0.002, \"k3\": -0.003, \"k4\": 0.0004";
  ExpectLens(Read("{" + lens + radial + ", \"camera_model\": \"OPENCV\", \"frames\": []}"), Radial());
  ExpectLens(Read("{" + lens + fisheye + ", \"camera_model\": \"OPENCV_FISHEYE\", \"frames\": []}"),
             Fisheye());
  ExpectLens(Read("{" + lens + fisheye + ", \"is_fisheye\": true}"), Fisheye());
  const std::string both = "{\"frames\": [{\"file_path\": \"a.png\", " + lens + radial +
                           "}, {\"file_path\": \"b.png\", " + lens + radial +
                           "}, {\"file_path\": \"c.png\", \"is_fisheye\": true, " + lens + fisheye + "}]}";
  EXPECT_THAT(ErrorOf(both), HasSubstr("2 cameras (1, 2)"));
  ExpectLens(Read(both, "1"), Radial());
  ExpectLens(Read(both, "2"), Fisheye());
  EXPECT_THAT(ErrorOf("{\"fl_x\": 600.5}"), HasSubstr("size of the pictures is missing"));
  EXPECT_THAT(ErrorOf("{" + lens + ", \"distortion_params\": [0.1, 0, 0, 0, 0, 0]}"),
              HasSubstr("distortion_params"));
  const ReadLens colmap =
      Read("# Camera list\n1 OPENCV 640 480 600.5 601.25 321 239.75 -0.1 0.05 0.001 -0.002\n");
  ExpectLens(colmap, Radial());
  EXPECT_EQ(colmap.program, "COLMAP");
}

}  // namespace
}  // namespace ulf::lens_programs_test
