// Tests: core/light_field/exchange/readers/gaussian_splatting_set,
// core/light_field/exchange/readers/polycam_set, core/light_field/exchange/readers/realityscan_csv,
// core/light_field/exchange/readers/euroc_set, core/light_field/exchange/readers/kitti_set,
// core/light_field/exchange/readers/timed_views, core/light_field/exchange/unread_sets.
//
// Sets of trainers, scanners and benchmarks, written here and drawn by their own formulas, and sets that are
// not read, which are named.
#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/points/point_io.h"
#include "tests/core/light_field/exchange/drawn_set.h"

namespace ulf::scanned_sets_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::DrawnCamera;
using test::Joined;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

Vector2d Straight(const Vector3d& p) { return 200 * p.head<2>() / p.z() + Vector2d(120, 90); }

class ScannedSet : public test::DrawnSet {
 protected:
  LightField Read(const std::string& place = "") const {
    return ReadPosedSet(scratch_ / place, {}, {}).light_field;
  }
  void ExpectRefused(const std::string& place, const std::string& words, const std::string& more = "") const {
    EXPECT_THAT([&] { Read(place); }, ThrowsMessage<Error>(AllOf(HasSubstr(words), HasSubstr(more))));
  }
};

// ---- gaussian-splatting ----

class GaussianSet : public ScannedSet {
 protected:
  // camera_to_JSON(): position and rotation of world_from_cam; the principal point is the middle.
  std::string Cameras(double fx = 200) const {
    std::string text;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const Matrix3d world_from_cam = cameras_[i].cam_from_world.transpose();
      text += fmt::format(
          R"({}{{"id": {}, "img_name": "shot_{}", "width": 240, "height": 180, "position": [{}],
"rotation": [[{}], [{}], [{}]], "fy": 200.0, "fx": {}}})",
          i == 0 ? "" : ", ", i, i, Joined(cameras_[i].center, ", "), Joined(world_from_cam.row(0), ", "),
          Joined(world_from_cam.row(1), ", "), Joined(world_from_cam.row(2), ", "), fx);
    }
    return "[" + text + "]";
  }
};

TEST_F(GaussianSet, FindsPhotographsAndPointsOfTheTraining) {
  Draw(scratch_ / "data/vase/images_2", Straight, 0.5);
  Write("output/1/cameras.json", "\xEF\xBB\xBF" + Cameras());
  Write("output/1/cfg_args",
        "Namespace(data_device='cuda', images='images_2', source_path='../../data/vase', sh_degree=3)");
  Write("output/1/input.ply", PointPlyBytes({{.position_in_world = {1, 2, 3}, .rgb = {9, 8, 7}}}));
  const LightField read = Read("output/1");
  ExpectSpots(read);
  EXPECT_THAT(read.doubts, IsEmpty());
  ASSERT_EQ(read.points.size(), 1u);
  EXPECT_EQ(read.points[0].position_in_world, Vector3d(1, 2, 3));
  EXPECT_THAT(FormatsIn(scratch_ / "output/1"), ElementsAre(SetFormat::kGaussian));
  EXPECT_EQ(PlaceOf(SetFormat::kTransforms, scratch_ / "output/1/cameras.json"), fs::path());
}

TEST_F(GaussianSet, WithoutThemItSaysHow) {
  Write("output/cameras.json", Cameras());
  ExpectRefused("output", "no photographs", "images");
  Draw(scratch_ / "output/images", Straight, 0.5);
  Write("output/cameras.json", Cameras(-1));
  ExpectRefused("output", "cameras.json, cameras 0", "'fx' must be positive");
  Write("output/cameras.json", R"([{"img_name": "shot_0", "width": 240, "height": 180, "fx": 9, "fy": 9,
"position": [0, 0, 0], "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}])");
  ExpectRefused("output", "is not a rotation");
}

// ---- Polycam ----

class PolycamSet : public ScannedSet {
 protected:
  void WriteCameras(const std::string& folder) const {
    for (const DrawnCamera& camera : cameras_) {
      // ARKit: x right, y up, z back.
      const Matrix3d world_from_cam =
          camera.cam_from_world.transpose() * Vector3d(1, -1, -1).asDiagonal().toDenseMatrix();
      std::string text =
          R"({"fx": 200, "fy": 198, "cx": 123, "cy": 88, "width": 240, "height": 180, "blur_score": 90.5)";
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
          text += fmt::format(R"(, "t_{}{}": {:.17g})", row, column,
                              column < 3 ? world_from_cam(row, column) : camera.center(row));
      Write(folder + "/" + fs::path(camera.name).stem().string() + ".json",
            text + R"(, "timestamp": 12, "neighbors": []})");
    }
  }
  static Vector2d Scanned(const Vector3d& p) { return {200 * p.x() / p.z() + 123, 198 * p.y() / p.z() + 88}; }
};

TEST_F(PolycamSet, CorrectedCamerasComeBeforeArKits) {
  Draw(scratch_ / "scan/keyframes/corrected_images", Scanned, 0.5);
  WriteCameras("scan/keyframes/corrected_cameras");
  fs::create_directories(scratch_ / "scan/keyframes/cameras");
  fs::create_directories(scratch_ / "scan/keyframes/images");
  const LightField read = Read("scan");
  ExpectSpots(read);
  EXPECT_THAT(read.doubts, IsEmpty());
  EXPECT_EQ(read.units, "metres");
  EXPECT_EQ(read.up_in_world, Vector3d(0, 1, 0));
  EXPECT_THAT(FormatsIn(scratch_ / "scan"), ElementsAre(SetFormat::kPolycam));
  EXPECT_EQ(Read("scan/keyframes").views.size(), 5u);
}

TEST_F(PolycamSet, WithoutThemTheScansPosesAreTaken) {
  Draw(scratch_ / "scan/keyframes/images", Scanned, 0.5);
  WriteCameras("scan/keyframes/cameras");
  fs::create_directories(scratch_ / "scan/keyframes/depth");
  WriteCameras("scan/keyframes/corrected_cameras");
  fs::create_directories(scratch_ / "scan/keyframes/corrected_images");  // but none is in it
  fs::remove(scratch_ / "scan/keyframes/images/shot_3.png");
  const LightField read = Read("scan");
  ExpectSpots(read, 4);
  EXPECT_THAT(read.doubts,
              ElementsAre(HasSubstr("1 view left out"), HasSubstr("ARKit"), HasSubstr("depth maps")));
  Write("scan/keyframes/cameras/shot_0.json", R"({"fx": 200})");
  ExpectRefused("scan", "shot_0.json", "'");
}

// ---- RealityScan's csv ----

class RealityScanTable : public ScannedSet {
 protected:
  static constexpr const char* kTitle = "#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2\n";
  // Returns "heading,pitch,roll" of a camera: Rz(-heading) Rx(pitch) Ry(roll) turns axes x right, y up, z
  // back to the world.
  static std::string Angles(const DrawnCamera& camera) {
    const Matrix3d m = camera.cam_from_world.transpose() * Vector3d(1, -1, -1).asDiagonal().toDenseMatrix();
    const double degree = 3.14159265358979323846 / 180;
    return fmt::format("{:.15g},{:.15g},{:.15g}", std::atan2(m(0, 1), m(1, 1)) / degree,
                       std::asin(m(2, 1)) / degree, std::atan2(-m(2, 0), m(2, 2)) / degree);
  }
  std::string Rows(const std::string& lens) const {
    std::string text;
    for (const DrawnCamera& camera : cameras_)
      text += fmt::format("{},{},{},{}\n", camera.name, Joined(camera.center, ","), Angles(camera), lens);
    return text;
  }
  // 30 mm of 36 mm over 240 px.
  static Vector2d Taken(const Vector3d& p, double k4) {
    const Vector2d m = p.head<2>() / p.z();
    const double r2 = m.squaredNorm(), radial = 1 + r2 * (-0.1 + r2 * (0.03 + r2 * (0.01 + r2 * k4)));
    return {200 * (m.x() * radial + 0.003 * (r2 + 2 * m.x() * m.x()) - 2 * 0.002 * m.x() * m.y()) + 120 +
                240 * 0.01,
            200 * (m.y() * radial - 0.002 * (r2 + 2 * m.y() * m.y()) + 2 * 0.003 * m.x() * m.y()) + 90 -
                240 * 0.02};
  }
};

// By hand: without any turn the camera looks down and its top is in the north; 90 degrees of heading turn the
// top to the east, 90 of pitch let it look to the north.
TEST_F(RealityScanTable, AnglesAreThoseOfAMap) {
  Draw(scratch_.path(), Straight, 0.5);
  Write("a.csv", std::string(kTitle) + "shot_0.png,1,2,3,0,0,0,30,0,0,0,0,0,0,0,0\n" +
                     "shot_1.png,1,2,3,90,0,0,30,0,0,0,0,0,0,0,0\n" +
                     "shot_2.png,1,2,3,0,90,0,30,0,0,0,0,0,0,0,0\n" +
                     "shot_3.png,1,2,3,0,90,90,30,0,0,0,0,0,0,0,0\n");
  const LightField read = Read("a.csv");
  ASSERT_EQ(read.views.size(), 4u);
  const auto expect = [&](std::size_t i, const Vector3d& forward, const Vector3d& top) {
    const Rigid3& pose = read.views[i].cam_from_world;
    EXPECT_LT((pose.DirectionInSource(Vector3d::UnitZ()) - forward).norm(), 1e-12) << i;
    EXPECT_LT((pose.DirectionInSource(-Vector3d::UnitY()) - top).norm(), 1e-12) << i;
    EXPECT_LT((pose.OriginInSource() - Vector3d(1, 2, 3)).norm(), 1e-12) << i;
  };
  expect(0, {0, 0, -1}, {0, 1, 0});
  expect(1, {0, 0, -1}, {1, 0, 0});
  expect(2, {0, 1, 0}, {0, 0, 1});
  expect(3, {-1, 0, 0}, {0, 0, 1});
  EXPECT_THAT(FormatsIn(scratch_.path()), ElementsAre(SetFormat::kRealityScan));
}

TEST_F(RealityScanTable, PosesAndLensesFitThePictures) {
  Draw(
      scratch_ / "images", [](const Vector3d& p) { return Taken(p, 0); }, 0.5);
  Write("cameras.csv", "\xEF\xBB\xBF#cameras 5\r\n" + std::string(kTitle) +
                           Rows("30,0.01,-0.02,-0.1,0.03,0.01,0,0.003,-0.002"));
  ExpectSpots(Read());
  Draw(
      scratch_ / "images", [](const Vector3d& p) { return Taken(p, -0.03); }, 0.5);
  Write("cameras.csv", kTitle + Rows("30,0.01,-0.02,-0.1,0.03,0.01,-0.03,0.003,-0.002"));
  ExpectSpots(Read());
  Write("cameras.csv", kTitle + Rows("30,0.01,-0.02,-0.1,0,0,0,0,0"));
  EXPECT_THAT(Read().doubts, ElementsAre(HasSubstr("the lens of 5 cameras has k1 alone")));
  // A spreadsheet may have kept it.
  Write("cameras.csv", "#Name, X, Y, Alt, Heading, Pitch, Roll, F, Px, Py, K1, K2, K3, K4, T1, T2\n" +
                           Rows("30,0.01,-0.02,-0.1,0.03,0.01,-0.03,0.003,-0.002"));
  ExpectSpots(Read());
}

// As spreadsheets of other countries keep it, with quotes around names that hold the separator.
TEST_F(RealityScanTable, SemicolonsTabsAndQuotesSeparate) {
  for (const char separator : {';', '\t', ','}) {
    for (std::size_t i = 0; i < cameras_.size(); ++i)
      cameras_[i].name = fmt::format("a{} {}.png", separator == '\t' ? ',' : separator, i);
    fs::remove_all(scratch_ / "images");
    Draw(scratch_ / "images", Straight, 0.5);
    std::string text = kTitle;
    for (const DrawnCamera& camera : cameras_)
      text += fmt::format("?,{},{},30,0,0,0,0,0,0,0,0\n", Joined(camera.center, ","), Angles(camera));
    if (separator != ',') {
      std::ranges::replace(text, ',', separator);
      std::ranges::replace(text, '.', ',');
    }
    for (const DrawnCamera& camera : cameras_) text.replace(text.find('?'), 1, "\"" + camera.name + "\"");
    Write("cameras.csv", text);
    ExpectSpots(Read(""));
  }
}

TEST_F(RealityScanTable, WhatIsMissingIsNamed) {
  Draw(scratch_.path(), Straight, 0.5);
  Write("a.csv", "#name,x,y,z,heading,pitch,roll\nshot_0.png,1,2,3,0,0,0\n");
  ExpectRefused("a.csv", "no column 'alt'", "Internal/External");
  Write("a.csv", "#name,x,y,alt,heading,pitch,roll,f\n" + Rows("30"));
  const LightField read = Read();
  ExpectSpots(read);
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("no columns px, py, k1")));
  Write("a.csv", std::string(kTitle) + "shot_0.png,1,2,3,0,0\n");
  ExpectRefused("a.csv", "a.csv, line 2", "has 6 cells");
  Write("a.csv", std::string(kTitle) + "shot_0.png,1,2,x,0,0,0,30,0,0,0,0,0,0,0,0\n");
  ExpectRefused("a.csv", "a.csv, line 2", "'x' in the column 'alt'");
}

// ---- EuRoC ----

class EurocSet : public ScannedSet {
 protected:
  EurocSet() {
    body_from_cam_.rotation = Eigen::AngleAxisd(1.5, Vector3d(0.1, 0.2, 1).normalized());
    body_from_cam_.translation = {-0.02, -0.06, 0.01};
    body_from_truth_.rotation = Eigen::AngleAxisd(-0.4, Vector3d(1, 0.2, 0).normalized());
    body_from_truth_.translation = {0.07, -0.1, 0.03};
  }
  static std::string Extrinsics(const Rigid3& body_from_sensor) {
    return "# General sensor definitions.\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [" +
           Joined(body_from_sensor.Matrix(), ",\n        ") + "]\n";
  }
  void WriteSensor(const std::string& model, const std::string& coefficients) const {
    Write("mav0/cam0/sensor.yaml",
          Extrinsics(body_from_cam_) +
              "rate_hz: 20\nresolution: [240, 180]\ncamera_model: pinhole\n"
              "intrinsics: [200, 199, 122.5, 87.5] #fu, fv, cu, cv\ndistortion_model: " +
              model + "\ndistortion_coefficients: [" + coefficients + "]\n");
  }
  // Photographs every 50 ms; two poses around each, of an even motion.
  void WriteTables(const std::string& truth) const {
    std::string photographs = "\xEF\xBB\xBF#timestamp [ns],filename\r\n",
                poses = "\xEF\xBB\xBF#timestamp, p_RS_R_x [m], ...\r\n";
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const std::int64_t time_ns = 1403636579763555584 + static_cast<std::int64_t>(i) * 50'000'000;
      photographs += fmt::format("{},{}\r\n", time_ns, cameras_[i].name);
      const Rigid3 cam_from_world{Eigen::Quaterniond(cameras_[i].cam_from_world), cameras_[i].Translation()};
      for (const int step : {-1, 1}) {
        const Rigid3 moved{
            Eigen::Quaterniond(Eigen::AngleAxisd(0.002 * step, Vector3d(1, 1, 0).normalized())),
            Vector3d::Zero()};
        const Rigid3 world_from_truth =
            (moved * cam_from_world).Inverse() * body_from_cam_.Inverse() * body_from_truth_;
        const Eigen::Quaterniond& q = world_from_truth.rotation;
        poses +=
            fmt::format("{},{},{:.17g},{:.17g},{:.17g},{:.17g},0.1,0.2,0.3\r\n", time_ns + step * 2'500'000,
                        Joined(world_from_truth.translation, ","), q.w(), q.x(), q.y(), q.z());
      }
    }
    Write("mav0/cam0/data.csv", photographs);
    Write("mav0/" + truth + "/data.csv", poses);
  }
  Rigid3 body_from_cam_, body_from_truth_;
};

TEST_F(EurocSet, PosesOfTheBodyBecomeTheCameras) {
  // Kalibr: the centre of the first pixel is at (0, 0).
  Draw(
      scratch_ / "mav0/cam0/data",
      [](const Vector3d& p) {
        const Vector2d m = p.head<2>() / p.z();
        const double r2 = m.squaredNorm(), radial = 1 - 0.2 * r2 + 0.05 * r2 * r2;
        return Vector2d(
            200 * (m.x() * radial + 2 * 0.002 * m.x() * m.y() - 0.001 * (r2 + 2 * m.x() * m.x())) + 122.5,
            199 * (m.y() * radial + 0.002 * (r2 + 2 * m.y() * m.y()) - 2 * 0.001 * m.x() * m.y()) + 87.5);
      },
      0);
  WriteSensor("radial-tangential", "-0.2, 0.05, 0.002, -0.001");
  WriteTables("state_groundtruth_estimate0");
  Write("mav0/state_groundtruth_estimate0/sensor.yaml", Extrinsics(body_from_truth_));
  const LightField read = Read();
  ExpectSpots(read);
  EXPECT_EQ(read.units, "metres");
  EXPECT_NEAR(read.views.at(1).device_time_s - read.views.at(0).device_time_s, 0.05, 1e-6);
  EXPECT_THAT(FormatsIn(scratch_.path()), ElementsAre(SetFormat::kEuroc));
  EXPECT_EQ(Read("mav0").views.size(), 5u);
}

TEST_F(EurocSet, FisheyesWithMotionCaptureAreRead) {
  Draw(
      scratch_ / "mav0/cam0/data",
      [](const Vector3d& p) {
        const double r = p.head<2>().norm() / p.z(), t = std::atan(r), t2 = t * t;
        const Vector2d m = t * (1 + 0.02 * t2 - 0.01 * t2 * t2) / r * p.head<2>() / p.z();
        return Vector2d(200 * m.x() + 122.5, 199 * m.y() + 87.5);
      },
      0);
  WriteSensor("equidistant", "0.02, -0.01, 0, 0");
  body_from_truth_ = {};  // the trajectory is the body's
  WriteTables("mocap0");
  ExpectSpots(Read());
}

TEST_F(EurocSet, DamageIsNamed) {
  Draw(scratch_ / "mav0/cam0/data", Straight, 0);
  WriteSensor("radial-tangential", "0, 0, 0, 0");
  ExpectRefused("", "state_groundtruth_estimate0/data.csv");
  WriteTables("mocap0");
  WriteSensor("fov", "0, 0, 0, 0");
  ExpectRefused("", "distortion_model is 'fov'");
  WriteSensor("equidistant", "0, 0");
  ExpectRefused("", "'distortion_coefficients' must have 4 numbers");
  WriteSensor("none", "");
  Write("mav0/mocap0/data.csv", "1403636579763555584,1,2,3,4,0,0,0\n");
  ExpectRefused("", "data.csv, line 1", "expected a pose");
  Write("mav0/mocap0/data.csv", "#nothing\n");
  ExpectRefused("", "holds no pose");
  WriteTables("mocap0");
  Write("mav0/cam0/data.csv", "");
  ExpectRefused("", "names no photograph");
}

// ---- KITTI ----

class KittiSet : public ScannedSet {
 protected:
  KittiSet() {
    for (std::size_t i = 0; i < cameras_.size(); ++i) cameras_[i].name = fmt::format("{:06}.png", i);
  }
  std::string Poses() const {
    std::string text;
    for (const DrawnCamera& camera : cameras_) {
      Eigen::Matrix<double, 3, 4> pose;
      pose << camera.cam_from_world.transpose(), camera.center;
      text += Joined(pose, " ") + "\n";
    }
    return text;
  }
  static constexpr const char* kCalib =
      "P0: 200 0 122 0 0 200 87 0 0 0 1 0\nP1: 200 0 122 -108 0 200 87 0 0 0 1 0\n"
      "P2: 200 0 122 12.5 0 200 87 -3.25 0 0 1 0.05\nTr: 1 0 0 0 0 1 0 0 0 0 1 0\n";
};

TEST_F(KittiSet, TheColourCameraStandsBesideTheFirst) {
  // u = P2 X, for X in the frame of the first camera.
  Draw(
      scratch_ / "sequences/03/image_2",
      [](const Vector3d& p) {
        const double w = p.z() + 0.05;
        return Vector2d((200 * p.x() + 122 * p.z() + 12.5) / w, (200 * p.y() + 87 * p.z() - 3.25) / w);
      },
      0);
  Draw(
      scratch_ / "sequences/03/image_0",
      [](const Vector3d& p) { return Vector2d(200 * p.head<2>() / p.z() + Vector2d(122, 87)); }, 0);
  Write("sequences/03/calib.txt", kCalib);
  Write("sequences/03/times.txt", "0\n0.1\n0.2\n0.3\n0.4\n");
  Write("poses/03.txt", Poses());
  const LightField read = Read("sequences/03");
  ExpectSpots(read);
  EXPECT_EQ(read.root.filename(), "image_2");
  EXPECT_EQ(read.views.at(2).device_time_s, 0.2);
  ExpectSpots(ReadPosedSet(scratch_ / "sequences/03", {}, scratch_ / "sequences/03/image_0").light_field);
  EXPECT_THAT(FormatsIn(scratch_ / "sequences/03"), ElementsAre(SetFormat::kKitti));
}

TEST_F(KittiSet, PhotographsAndPosesAreMatchedByNumber) {
  Draw(
      scratch_ / "seq/image_0",
      [](const Vector3d& p) { return Vector2d(200 * p.head<2>() / p.z() + Vector2d(122, 87)); }, 0);
  Write("seq/calib.txt", kCalib);
  ExpectRefused("seq", "no poses", "seq.txt");
  Write("seq/poses.txt", Poses());
  fs::remove(scratch_ / "seq/image_0/000001.png");
  fs::copy(scratch_ / "seq/image_0/000000.png", scratch_ / "seq/image_0/000007.png");
  // Raw data have longer numbers.
  fs::rename(scratch_ / "seq/image_0/000003.png", scratch_ / "seq/image_0/0000000003.png");
  const LightField read = Read("seq");
  ExpectSpots(read, 4);
  EXPECT_THAT(read.doubts,
              ElementsAre(HasSubstr("1 photograph left out"), HasSubstr("1 of 5 poses left out")));
  Draw(scratch_ / "small/image_0", [](const Vector3d&) { return Vector2d(9, 9); }, 0, {120, 90});
  Write("small/calib.txt", kCalib);
  Write("small/poses.txt", Poses());
  ExpectRefused("small", "principal point (122.5, 87.5)", "that were measured");
  Write("seq/poses.txt", Poses() + "1 0 0 0\n");
  ExpectRefused("seq", "poses.txt, line 6", "12 numbers");
  Write("seq/poses.txt", "2 0 0 0 0 1 0 0 0 0 1 0\n");
  ExpectRefused("seq", "poses.txt, line 1", "not a rotation");
}

// ---- What is not read ----

TEST_F(ScannedSet, WhatIsNotReadIsNamedWithWhatConvertsIt) {
  Draw(scratch_ / "a", Straight, 0.5);
  const std::vector<std::pair<std::string, std::string>> files{
      {"sfm.abc", "cameras.sfm"},
      {"vase.psx", "Export Cameras"},
      {"vase.rsproj", "Internal/External"},
      {"sfm_data.bin", "ConvertSfM_DataFormat"},
      {"vase.mg", "StructureFromMotion"},
      {"scene.mvs", "InterfaceCOLMAP"},
      {"take.r3d", "record3d"},
      {"cameras_sphere.npz", "from_neus.py"},
      {"frame-000000.pose.txt", "negated"},
      {"Barn_COLMAP_SfM.log", "negated"},
      {"scene0000.sens", "SensReader"},
      {"vase.blend", "BlenderNeRF"},
      {"pair.txt", "COLMAP model"},
      {"vase_calibrated_camera_parameters.txt", "Pix4D"},
      {"metadata", "record3d2nerf.py"},
      {"bbox.txt", "nsvf2nerf.py"},
      {"database.db", "colmap mapper"},
      {"raw.zip", "unpack it"}};
  for (const auto& [name, words] : files) {
    Write("a/" + name, "x");
    ExpectRefused("a/" + name, name, words);
    if (name != "raw.zip") ExpectRefused("a", name, words);
    fs::remove(scratch_ / "a" / name);
  }
  Write("a/block.xml", "<?xml version=\"1.0\"?>\n<BlocksExchange version=\"3.2\">");
  ExpectRefused("a", "block.xml", "Agisoft XML");
  Write("a/block.xml", "<svg/>");
  Write("a/Thumbs.db", "x");
  EXPECT_THAT([&] { Read("a"); }, ThrowsMessage<Error>(HasSubstr("photographs without poses")));
}

}  // namespace
}  // namespace ulf::scanned_sets_test
