// Tests: core/light_field/exchange/readers/meshroom_set, core/light_field/exchange/readers/opensfm_set,
// core/light_field/exchange/readers/openmvg_set, core/light_field/exchange/readers/visualsfm_set,
// core/light_field/exchange/readers/named_views, core/light_field/formats/fitted_lens.
//
// Sets of structure-from-motion programs, written here and drawn by the formulas of their own sources: poses,
// lenses and the place of the first pixel are right if points fall on the spots of the pictures.
#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/light_field/exchange/poses_of_set.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/formats/set_format.h"
#include "tests/core/light_field/exchange/drawn_set.h"

namespace ulf::sfm_sets_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::DrawnCamera;
using test::Joined;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::ThrowsMessage;

// ---- Meshroom ----

// Brown's distortion as AliceVision has it (DistortionBrown.cpp): k1 k2 k3 t1 t2.
Vector2d AliceBrown(const Vector2d& p, const std::array<double, 5>& k) {
  const double r2 = p.squaredNorm(), radial = 1 + k[0] * r2 + k[1] * r2 * r2 + k[2] * r2 * r2 * r2;
  return {p.x() * radial + k[4] * (r2 + 2 * p.x() * p.x()) + 2 * k[3] * p.x() * p.y(),
          p.y() * radial + k[3] * (r2 + 2 * p.y() * p.y()) + 2 * k[4] * p.x() * p.y()};
}

class MeshroomSet : public test::DrawnSet {
 protected:
  // A pose as savePose3() writes it: column by column.
  static std::string PoseText(const Eigen::Matrix3d& rotation, const Vector3d& center) {
    return fmt::format(R"("rotation": [{}], "center": [{}])", Joined(rotation, ", ", true, "\""),
                       Joined(center, ", ", false, "\""));
  }
  // `intrinsics` are the values of the one camera after its number; `more` of the file.
  std::string Document(const std::string& version, const std::string& intrinsics,
                       const std::string& more = "") const {
    std::string views, poses;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      views += fmt::format(
          R"({}{{"viewId": "{}", "poseId": "{}", "intrinsicId": "77", "path": "{}", "width": "240", "metadata": ""}})",
          i == 0 ? "" : ",\n", 900 + i, 900 + i, folder_ + cameras_[i].name);
      poses +=
          fmt::format(R"({}{{"poseId": "{}", "pose": {{"transform": {{{}}}, "locked": "0"}}}})",
                      i == 0 ? "" : ",\n", 900 + i, PoseText(cameras_[i].cam_from_world, cameras_[i].center));
    }
    // A view that was not reconstructed, as they all keep them.
    views += R"(, {"viewId": "5", "poseId": "5", "intrinsicId": "77", "path": "/far/away/shot_9.png"})";
    return fmt::format(
        R"({{"version": [{}], "featuresFolders": ["x"], "views": [{}],
"intrinsics": [{{"intrinsicId": "77", {}}}],
"poses": [{}]{}}})",
        version, views, intrinsics, poses, more);
  }
  LightField Read() const { return ReadPosedSet(scratch_ / "cameras.sfm", {}, {}).light_field; }
  void ExpectRefused(const std::string& intrinsics, const std::string& words) const {
    Write("cameras.sfm", Document(kVersion, intrinsics));
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(AllOf(HasSubstr("intrinsics 0"), HasSubstr(words))));
  }

  static constexpr const char* kVersion = R"("1", "2", "8")";
  // 200 px of 240 px over 36 mm; the offset is that of the principal point from the middle.
  static constexpr const char* kPinhole =
      R"("width": "240", "height": "180", "sensorWidth": "36", "sensorHeight": "27", "serialNumber": "",
"type": "pinhole", "focalLength": "30", "pixelRatio": "1", "principalPoint": ["3", "-2"])";
  std::string folder_ = "C:\\\\shoot\\\\";
};

TEST_F(MeshroomSet, PosesAndBrownLensFitThePictures) {
  const std::array<double, 5> k{-0.2, 0.06, 0.01, 0.004, -0.006};
  Draw(
      scratch_ / "images",
      [&](const Vector3d& p) {
        return Vector2d(200 * AliceBrown(p.head<2>() / p.z(), k) + Vector2d(120 + 3, 90 - 2));
      },
      0);
  Write("cameras.sfm", Document(kVersion, std::string(kPinhole) +
                                              R"(, "distortionType": "brown", "undistortionType": "none",
"distortionParams": ["-0.2", "0.06", "0.01", "0.004", "-0.006"])"));
  const LightField read = Read();
  ExpectSpots(read);
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("1 view left out: without a pose")));
  EXPECT_THAT(FormatsIn(scratch_.path()), ElementsAre(SetFormat::kMeshroom));
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_LT((read.views[i].CenterInWorld() - cameras_[i].center).norm(), 1e-9);
}

// The sample scene that AliceVision keeps in every version of its files (compatibilityData/) has a camera
// with the focal lengths 1000 and 2000 px, 26 px left and 16 px below the middle of 4092x2048 pixels.
TEST_F(MeshroomSet, LensesOfAllVersionsAreTheSame) {
  const std::string size =
      R"("width": "4092", "height": "2048", "sensorWidth": "36", "sensorHeight": "24", )";
  const std::string k3 = R"(, "distortionParams": ["0.10000000000000001", "0.050000000000000003", "-0.001"])";
  const std::string typed = R"(, "distortionType": "radialk3", "undistortionType": "none")";
  const std::vector<std::pair<std::string, std::string>> files{
      {R"("1", "2", "0")",
       R"("type": "radial3", "pxFocalLength": ["1000", "2000"], "principalPoint": ["2020", "1040"])"},
      {R"("1", "2", "1")",
       R"("type": "radial3", "pxFocalLength": ["1000", "2000"], "principalPoint": ["-26", "16"])"},
      {R"("1", "2", "3")",
       R"("type": "radial3", "focalLength": "8.7976539589442808", "pixelRatio": "0.5", "principalPoint": ["-26", "16"])"},
      {R"("1", "2", "6")",
       R"("type": "radial3", "focalLength": "8.7976539589442808", "pixelRatio": "2", "principalPoint": ["-26", "16"])"},
      {R"("1", "2", "8")",
       R"("type": "pinhole", "focalLength": "8.7976539589442808", "pixelRatio": "2", "principalPoint": ["-26", "16"])" +
           typed},
      {R"("1", "2", "14")",
       R"("type": "pinhole", "focalLength": "17.595307917888562", "pixelRatio": "2", "principalPoint": ["-26", "16"])" +
           typed}};
  Draw(scratch_ / "images", [](const Vector3d&) { return Vector2d(0, 0); }, 0, {4092 / 4, 2048 / 4});
  for (const auto& [version, intrinsics] : files) {
    Write("cameras.sfm", Document(version, size + intrinsics + k3));
    const CameraModel camera = Read().cameras.at(0).ScaledTo(4092, 2048);
    EXPECT_NEAR(camera.fx, 1000, 1e-6) << version;
    EXPECT_NEAR(camera.fy, 2000, 1e-6) << version;
    EXPECT_NEAR(camera.cx, 2020.5, 1e-6) << version;
    EXPECT_NEAR(camera.cy, 1040.5, 1e-6) << version;
    EXPECT_EQ(camera.coefficients, (std::array<double, 5>{0.1, 0.05, 0, 0, -0.001})) << version;
  }
}

TEST_F(MeshroomSet, FisheyesFitThePictures) {
  // Pinhole cameras with OpenCV's fisheye, and the one of Devernay and Faugeras, which is fitted.
  Draw(
      scratch_ / "images",
      [](const Vector3d& p) {
        const double r = p.head<2>().norm() / p.z(), theta = std::atan(r), t2 = theta * theta;
        const double radius = theta * (1 + t2 * (-0.04 + t2 * (0.01 + t2 * (-0.003 + t2 * 0.0005))));
        return Vector2d(200 * radius / r * p.head<2>() / p.z() + Vector2d(123, 88));
      },
      0);
  Write("cameras.sfm", Document(kVersion, std::string(kPinhole) + R"(, "distortionType": "fisheye",
"distortionParams": ["-0.04", "0.01", "-0.003", "0.0005"])"));
  ExpectSpots(Read());

  Draw(
      scratch_ / "images",
      [](const Vector3d& p) {
        const Vector2d m = p.head<2>() / p.z();
        return Vector2d(200 * std::atan(2 * m.norm() * std::tan(0.5 * 0.9)) / (0.9 * m.norm()) * m +
                        Vector2d(123, 88));
      },
      0);
  Write("cameras.sfm",
        Document(kVersion,
                 std::string(kPinhole) + R"(, "distortionType": "fisheye1", "distortionParams": ["0.9"])"));
  ExpectSpots(Read());

  // Equidistant.cpp: an angle of 1 is 2 f sensorWidth / max(w, h) / min(sensor) of the circle's radius.
  Draw(
      scratch_ / "images",
      [](const Vector3d& p) {
        const double theta = std::atan2(p.head<2>().norm(), p.z());
        const double r = theta * 2 * 200 * (36.0 / 240) / 27, r2 = r * r;
        const double k = (1 + 0.1 * r2 - 0.02 * r2 * r2 + 0.005 * r2 * r2 * r2) / (1 + 0.1 - 0.02 + 0.005);
        return Vector2d(85 * r * k * p.head<2>().normalized() + Vector2d(123, 88));
      },
      0);
  std::string equidistant = kPinhole;
  equidistant.replace(equidistant.find("pinhole"), 7, "equidistant");
  Write("cameras.sfm",
        Document(kVersion, equidistant + R"(, "distortionType": "radialk3pt", "fisheyeCircleRadius": "85",
"distortionParams": ["0.1", "-0.02", "0.005"])"));
  ExpectSpots(Read());
}

TEST_F(MeshroomSet, RigsAndPointsAreRead) {
  Draw(
      scratch_ / "images",
      [](const Vector3d& p) { return Vector2d(200 * p.head<2>() / p.z() + Vector2d(123, 88)); }, 0);
  // The first two views are one rig, whose pose is that of neither.
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Vector3d place(0.4, -0.3, 0.2);
  std::string document = Document(kVersion, std::string(kPinhole));
  std::string cameras;
  for (std::size_t i = 0; i < 2; ++i) {
    // cam_from_world = sub * rig, with rig = (turn, place): the sub-pose's rotation and centre follow.
    const Eigen::Matrix3d rotation = cameras_[i].cam_from_world * turn.transpose();
    const Vector3d center = turn * (cameras_[i].center - place);
    cameras += fmt::format(R"({}{{"status": "estimated", "pose": {{{}}}}})", i == 0 ? "" : ", ",
                           PoseText(rotation, center));
    const std::string id = fmt::format(R"("viewId": "{0}", "poseId": "{0}")", 900 + i);
    document.replace(document.find(id), id.size(),
                     fmt::format(R"("viewId": "{}", "poseId": "800", "rigId": "3", "subPoseId": "{}",
"isPoseIndependant": "false")",
                                 900 + i, i));
  }
  document.pop_back();
  std::string structure;
  for (const Vector3d& point : points_) {
    std::string seen;
    for (std::size_t i = 0; i < 5; ++i) {
      const Vector3d p = cameras_[i].InCam(point);
      seen += fmt::format(
          R"({}{{"observationId": "{}", "featureId": "1", "x": ["{:.12f}", "{:.12f}"], "scale": "0"}})",
          i == 0 ? "" : ", ", 900 + i, 200 * p.x() / p.z() + 123, 200 * p.y() / p.z() + 88);
    }
    structure += fmt::format(
        R"({}{{"landmarkId": "1", "color": ["10", "20", "30"], "X": [{}], "observations": [{}]}})",
        structure.empty() ? "" : ", ", Joined(point, ", ", false, "\""), seen);
  }
  structure += R"(, {"landmarkId": "2", "X": ["nan", "0", "1"], "observations": []})";
  const std::string pose =
      fmt::format(R"({{"poseId": "800", "pose": {{"transform": {{{}}}}}}}, )", PoseText(turn, place));
  document.insert(document.find("\"poses\": [") + 10, pose);
  Write("cameras.sfm",
        document + fmt::format(R"(, "rigs": [{{"rigId": "3", "subPoses": [{}]}}], "structure": [{}]}})",
                               cameras, structure));
  const LightField read = Read();
  ExpectSpots(read);
  EXPECT_THAT(read.doubts, Contains(HasSubstr("1 point whose position is not finite: left out")));
  ASSERT_EQ(read.points.size(), points_.size());
  EXPECT_EQ(read.misplaced_observations, 0u);
  for (const ScenePoint& point : read.points) {
    EXPECT_EQ(point.track.size(), 5u);
    EXPECT_LT(point.error_px, 1e-6);
    EXPECT_EQ(point.rgb, (std::array<std::uint8_t, 3>{10, 20, 30}));
  }
}

TEST_F(MeshroomSet, OtherLensesAndDamageAreNamed) {
  Draw(
      scratch_ / "images", [](const Vector3d&) { return Vector2d(9, 9); }, 0);
  ExpectRefused(std::string(kPinhole) + R"(, "distortionType": "none", "undistortionType": "3deanamorphic4")",
                "3deanamorphic4");
  ExpectRefused(std::string(kPinhole) + R"(, "undistortionType": "radialk3")", "undistortion by radialk3");
  ExpectRefused(std::string(kPinhole) + R"(, "distortionType": "brown", "distortionParams": ["1"])", "has 5");
  std::string odd = kPinhole;
  odd.replace(odd.find("pinhole"), 7, "equirectangular");
  ExpectRefused(odd, "equirectangular");
  Write("cameras.sfm", R"({"version": ["1","2","8"], "views": [{"viewId": "1", "path": "a.png"}]})");
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("StructureFromMotion")));
  // Since 1.2.11 upright photographs have two meanings.
  Write("cameras.sfm", Document(R"("1", "2", "12")",
                                R"("width": "180", "height": "240", "sensorWidth": "36", "type": "pinhole",
"focalLength": "30", "pixelRatio": "1", "principalPoint": ["0", "0"])"));
  Draw(scratch_ / "images", [](const Vector3d&) { return Vector2d(9, 9); }, 0, {180, 240});
  const LightField upright = Read();
  EXPECT_NEAR(upright.cameras.at(0).fx, 200, 1e-9);
  EXPECT_THAT(upright.doubts, Contains(HasSubstr("upright photographs")));
}

TEST_F(MeshroomSet, PhotographsLieWhereTheirPathsSay) {
  folder_ = (scratch_ / "shoot/day 1/").string();
  Draw(
      folder_, [](const Vector3d& p) { return Vector2d(200 * p.head<2>() / p.z() + Vector2d(123, 88)); }, 0);
  Write("cache/cameras.sfm", Document(kVersion, kPinhole));
  ExpectSpots(ReadPosedSet(scratch_ / "cache", {}, {}).light_field);
  // Missing ones are left out, unless they are the most.
  fs::remove(fs::path(folder_) / "shot_0.png");
  fs::remove(fs::path(folder_) / "shot_1.png");
  const LightField fewer = ReadPosedSet(scratch_ / "cache", {}, {}).light_field;
  ExpectSpots(fewer, 3);
  EXPECT_THAT(fewer.doubts, Contains(AllOf(HasSubstr("2 views left out"), HasSubstr("shot_0.png"))));
  fs::remove(fs::path(folder_) / "shot_2.png");
  EXPECT_THAT([&] { ReadPosedSet(scratch_ / "cache", {}, {}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("3 of its 5 photographs"), HasSubstr("images"))));
}

// As camera paths poses need no photographs, and go in the order of names: AliceVision's numbers have none.
void ExpectPathOf(const std::vector<DrawnCamera>& cameras, const SetPoses& path) {
  ASSERT_EQ(path.cam_from_world.size(), cameras.size());
  ASSERT_EQ(path.cameras.size(), cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    EXPECT_LT((path.cam_from_world[i].rotation.toRotationMatrix() - cameras[i].cam_from_world).norm(), 1e-9)
        << i;
    EXPECT_LT((path.cam_from_world[i].OriginInSource() - cameras[i].center).norm(), 1e-9) << i;
    EXPECT_EQ(path.cameras[i].width, 240) << i;
    EXPECT_NEAR(path.cameras[i].fx, 200, 1e-9) << i;
  }
}

TEST_F(MeshroomSet, MakesACameraPathWithoutPhotographs) {
  std::ranges::reverse(cameras_);
  cameras_[0].name = "shot_10.png";
  Write("cameras.sfm", Document(kVersion, kPinhole));
  std::ranges::reverse(cameras_);
  ExpectPathOf(cameras_, ReadPosesOfSet(scratch_ / "cameras.sfm"));
  ExpectPathOf(cameras_, ReadPosesOfSet(scratch_.path()));
}

// ---- OpenSfM ----

class OpenSfmSet : public test::DrawnSet {
 protected:
  std::string Reconstruction(const std::string& camera, std::size_t shots = 5) const {
    std::string text;
    for (std::size_t i = 0; i < shots; ++i) {
      const Eigen::AngleAxisd turn(cameras_[i].cam_from_world);
      text += fmt::format(
          R"({}"{}": {{"rotation": [{}], "translation": [{}], "camera": "v2 a", "orientation": 6}})",
          i == 0 ? "" : ",\n", cameras_[i].name, Joined(turn.angle() * turn.axis(), ", "),
          Joined(cameras_[i].Translation(), ", "));
    }
    return fmt::format(R"({{"cameras": {{"v2 a": {{{}}}}}, "shots": {{{}}},
"points": {{"0": {{"color": [1, 2, 300], "coordinates": [1, 2, 3]}}}}}})",
                       camera, text);
  }
  LightField Read() const { return ReadPosedSet(scratch_ / "reconstruction.json", {}, {}).light_field; }
  static constexpr const char* kSize = R"("width": 240, "height": 180, )";
};

TEST_F(OpenSfmSet, BrownLensOfTheLargestFitsThePictures) {
  // doc/source/geometry.rst: image coordinates are 0 in the middle, 1 is the larger side.
  Draw(
      scratch_ / "images",
      [](const Vector3d& p) {
        const Vector2d d = AliceBrown(p.head<2>() / p.z(), {-0.15, 0.05, -0.01, 0.003, -0.004});
        return Vector2d(240 * (0.85 * d.x() + 0.01) + 120, 240 * (0.86 * d.y() - 0.02) + 90);
      },
      0.5);
  const std::string camera =
      std::string(kSize) + R"("projection_type": "brown", "focal_x": 0.85, "focal_y": 0.86,
"c_x": 0.01, "c_y": -0.02, "k1": -0.15, "k2": 0.05, "k3": -0.01, "p1": 0.003, "p2": -0.004)";
  Write("reconstruction.json",
        "\xEF\xBB\xBF[" + Reconstruction(camera, 2) + ",\n" + Reconstruction(camera) + "]");
  const LightField read = Read();
  ExpectSpots(read);
  EXPECT_THAT(read.doubts, ElementsAre(AllOf(HasSubstr("of 2 reconstructions"), HasSubstr("5 shots"))));
  ASSERT_EQ(read.points.size(), 1u);
  EXPECT_EQ(read.points[0].position_in_world, Vector3d(1, 2, 3));
  EXPECT_EQ(read.points[0].rgb, (std::array<std::uint8_t, 3>{1, 2, 255}));
  EXPECT_THAT(FormatsIn(scratch_.path()), ElementsAre(SetFormat::kOpenSfm));
  // OpenDroneMap has it one folder deeper.
  fs::create_directories(scratch_ / "opensfm");
  fs::rename(scratch_ / "reconstruction.json", scratch_ / "opensfm/reconstruction.json");
  ExpectSpots(ReadPosedSet(scratch_.path(), {}, {}).light_field);
}

TEST_F(OpenSfmSet, TheUsualFileGoesBeforeOthers) {
  Draw(
      scratch_ / "images",
      [](const Vector3d& p) { return Vector2d(200 * p.head<2>() / p.z() + Vector2d(120, 90)); }, 0.5);
  const std::string camera =
      std::string(kSize) + R"("projection_type": "perspective", "focal": 0.83333333333333333)";
  // Points may lack colours, and Python writes NaN for what it does not know.
  std::string text = "[" + Reconstruction(camera) + "]";
  text.replace(text.find("\"color\": [1, 2, 300]"), 20, "\"reprojection\": NaN");
  text.insert(text.find("\"points\": {") + 11, "\"1\": {\"coordinates\": [0, -Infinity, 1]}, ");
  Write("reconstruction.json", text);
  Write("reconstruction.geocoords.json", "[" + Reconstruction(camera, 2) + "]");
  const LightField read = ReadPosedSet(scratch_.path(), {}, {}).light_field;
  ExpectSpots(read);
  EXPECT_THAT(read.doubts, Contains(AllOf(HasSubstr("reconstruction.json: is read"),
                                          HasSubstr("not reconstruction.geocoords.json"))));
  fs::remove(scratch_ / "reconstruction.geocoords.json");
  EXPECT_THAT(ReadPosedSet(scratch_.path(), {}, {}).light_field.doubts,
              ElementsAre(HasSubstr("1 point whose position is not finite: left out")));
}

TEST_F(OpenSfmSet, MakesACameraPathWithoutPhotographs) {
  cameras_[4].name = "shot_10.png";
  Write("reconstruction.json", "[" + Reconstruction(std::string(kSize) + R"("projection_type": "perspective",
"focal": 0.83333333333333333)") + "]");
  ExpectPathOf(cameras_, ReadPosesOfSet(scratch_ / "reconstruction.json"));
}

TEST_F(OpenSfmSet, FisheyesFitThePictures) {
  const auto long_fisheye = [](const Vector3d& p, bool with_all) {
    const double theta = std::atan2(p.head<2>().norm(), p.z()), t2 = theta * theta;
    const Vector2d m = theta * p.head<2>().normalized();
    double radial = 1 + -0.03 * t2 + 0.02 * t2 * t2;
    Vector2d more(0, 0);
    if (with_all) {
      radial += -0.004 * std::pow(t2, 3) + 0.001 * std::pow(t2, 4) - 0.0005 * std::pow(t2, 5);
      more = {2 * 0.0006 * m.x() * m.y() - 0.0004 * (t2 + 2 * m.x() * m.x()),
              2 * -0.0004 * m.x() * m.y() + 0.0006 * (t2 + 2 * m.y() * m.y())};
    }
    return Vector2d(200 * (radial * m + more) + Vector2d(120, 90));
  };
  Draw(
      scratch_ / "images", [&](const Vector3d& p) { return long_fisheye(p, false); }, 0.5);
  Write("reconstruction.json", "[" + Reconstruction(std::string(kSize) + R"("projection_type": "fisheye",
"focal": 0.83333333333333333, "k1": -0.03, "k2": 0.02)") +
                                   "]");
  ExpectSpots(Read());

  Draw(
      scratch_ / "images", [&](const Vector3d& p) { return long_fisheye(p, true); }, 0.5);
  Write("reconstruction.json",
        "[" +
            Reconstruction(std::string(kSize) +
                           R"("projection_type": "fisheye62", "focal_x": 0.83333333333333333,
"focal_y": 0.83333333333333333, "c_x": 0, "c_y": 0, "k1": -0.03, "k2": 0.02, "k3": -0.004, "k4": 0.001, "k5": -0.0005,
"k6": 0, "p1": 0.0006, "p2": -0.0004)") +
            "]");
  const LightField read = Read();
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("the lens fisheye62 of OpenSfM is taken into our model")));
  for (const View& view : read.views)
    for (const Vector3d& point : points_) {
      const auto img = read.CameraOf(view).ImgFromCam(view.cam_from_world * point);
      ASSERT_TRUE(img);
      EXPECT_LT((*img - long_fisheye(view.cam_from_world * point, true)).norm(), 0.4);
    }
}

TEST_F(OpenSfmSet, PanoramasAndDamageAreNamed) {
  Draw(
      scratch_ / "images", [](const Vector3d&) { return Vector2d(9, 9); }, 0);
  const auto expect = [&](const std::string& text, const std::string& words) {
    Write("reconstruction.json", text);
    EXPECT_THAT([&] { Read(); },
                ThrowsMessage<Error>(AllOf(HasSubstr("reconstruction.json"), HasSubstr(words))));
  };
  expect("[" + Reconstruction(std::string(kSize) + R"("projection_type": "spherical")") + "]", "'spherical'");
  expect("[" + Reconstruction(std::string(kSize) + R"("projection_type": "dual", "focal": 1)") + "]",
         "'dual'");
  expect(R"([{"shots": {}, "cameras": {}}])", "opensfm reconstruct");
  expect(R"([{"shots": {"shot_0.png": {"rotation": [0, 0], "translation": [0, 0, 0], "camera": "x"}}}])",
         "no camera 'x'");
}

// ---- openMVG ----

class OpenMvgSet : public test::DrawnSet {
 protected:
  // Writes it as cereal does, which names a type once and gives it a number.
  static std::string Intrinsic(int key, const std::string& type, const std::string& data) {
    return fmt::format(
        R"({{"key": {}, "value": {{{}, "ptr_wrapper": {{"id": {}, "data": {{"width": 240, "height": 180,
"focal_length": 200.0, "principal_point": [123.0, 88.0]{}}}}}}}}})",
        key, type, 2147483700u + static_cast<unsigned>(key), data);
  }
  std::string Document(const std::string& intrinsics, const std::string& structure = "") const {
    std::string views, poses;
    for (std::size_t i = 0; i < 6; ++i) {
      const DrawnCamera& camera = cameras_[i % 5];
      views += fmt::format(
          R"({}{{"key": {}, "value": {{"polymorphic_id": 1073741824, "ptr_wrapper": {{"id": 2147483649,
"data": {{"local_path": "", "filename": "{}", "width": 240, "height": 180, "id_view": {}, "id_intrinsic": {},
"id_pose": {}}}}}}}}})",
          i == 0 ? "" : ",\n", i, i < 5 ? camera.name : "shot_8.png", i, i % 2, 40 + i);
      if (i == 5) continue;  // no pose
      poses += fmt::format(R"({}{{"key": {}, "value": {{"rotation": [[{}], [{}], [{}]], "center": [{}]}}}})",
                           i == 0 ? "" : ",\n", 40 + i, Joined(camera.cam_from_world.row(0), ", "),
                           Joined(camera.cam_from_world.row(1), ", "),
                           Joined(camera.cam_from_world.row(2), ", "), Joined(camera.center, ", "));
    }
    return fmt::format(R"({{"sfm_data_version": "0.3", "root_path": "/data/else/images", "views": [{}],
"intrinsics": [{}], "extrinsics": [{}], "structure": [{}], "control_points": []}})",
                       views, intrinsics, poses, structure);
  }
  LightField Read() const { return ReadPosedSet(scratch_ / "sfm_data.json", {}, {}).light_field; }
};

TEST_F(OpenMvgSet, MakesACameraPathWithoutPhotographs) {
  Write("sfm_data.json",
        Document(Intrinsic(0, R"("polymorphic_id": 2147483649, "polymorphic_name": "pinhole")", "") + ",\n" +
                 Intrinsic(1, R"("polymorphic_id": 1)", "")));
  ExpectPathOf(cameras_, ReadPosesOfSet(scratch_ / "sfm_data.json"));
}

TEST_F(OpenMvgSet, BrownLensAndPointsFitThePictures) {
  const auto formula = [](const Vector3d& p) {
    return Vector2d(200 * AliceBrown(p.head<2>() / p.z(), {-0.18, 0.05, 0.01, 0.003, -0.002}) +
                    Vector2d(123, 88));
  };
  Draw(scratch_ / "images", formula, 0);
  const std::string disto = R"(, "disto_t2": [-0.18, 0.05, 0.01, 0.003, -0.002])";
  std::string structure;
  for (const Vector3d& point : points_) {
    std::string seen;
    for (std::size_t i = 0; i < 5; ++i)
      seen += fmt::format(R"({}{{"key": {}, "value": {{"id_feat": 7, "x": [{}]}}}})", i == 0 ? "" : ", ", i,
                          Joined(formula(cameras_[i].InCam(point)), ", "));
    structure += fmt::format(R"({}{{"key": 1, "value": {{"X": [{}], "observations": [{}]}}}})",
                             structure.empty() ? "" : ", ", Joined(point, ", "), seen);
  }
  structure += R"(, {"key": 2, "value": {"X": [NaN, 0, 1], "observations": []}})";
  Write("sfm_data.json",
        Document(
            Intrinsic(0, R"("polymorphic_id": 2147483650, "polymorphic_name": "pinhole_brown_t2")", disto) +
                ", " + Intrinsic(1, R"("polymorphic_id": 2)", disto),
            structure));
  const LightField read = Read();
  ExpectSpots(read);
  EXPECT_EQ(read.cameras.size(), 1u);
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("1 view left out: without a pose"),
                                       HasSubstr("1 point whose position is not finite: left out")));
  ASSERT_EQ(read.points.size(), points_.size());
  for (const ScenePoint& point : read.points) {
    EXPECT_EQ(point.track.size(), 5u);
    EXPECT_LT(point.error_px, 1e-6);
  }
  EXPECT_THAT(FormatsIn(scratch_.path()), ElementsAre(SetFormat::kOpenMvg));
}

TEST_F(OpenMvgSet, RadialAndFisheyeFitThePictures) {
  Draw(
      scratch_ / "images",
      [](const Vector3d& p) {
        const Vector2d m = p.head<2>() / p.z();
        const double r2 = m.squaredNorm();
        return Vector2d(200 * (1 - 0.2 * r2 + 0.06 * r2 * r2 - 0.01 * r2 * r2 * r2) * m + Vector2d(123, 88));
      },
      0);
  const std::string k3 = R"("polymorphic_id": 2147483649, "polymorphic_name": "pinhole_radial_k3")";
  Write("sfm_data.json", Document(Intrinsic(0, k3, R"(, "disto_k3": [-0.2, 0.06, -0.01])") + ", " +
                                  Intrinsic(1, k3, R"(, "disto_k3": [-0.2, 0.06, -0.01])")));
  ExpectSpots(Read());
  Draw(
      scratch_ / "images",
      [](const Vector3d& p) {
        const double r = p.head<2>().norm() / p.z(), t = std::atan(r), t2 = t * t;
        return Vector2d(200 * t * (1 - 0.03 * t2 + 0.01 * t2 * t2) / r * p.head<2>() / p.z() +
                        Vector2d(123, 88));
      },
      0);
  const std::string fisheye = R"("polymorphic_id": 2147483649, "polymorphic_name": "fisheye")";
  Write("sfm_data.json", Document(Intrinsic(0, fisheye, R"(, "fisheye": [-0.03, 0.01, 0, 0])") + ", " +
                                  Intrinsic(1, fisheye, R"(, "fisheye": [-0.03, 0.01, 0, 0])")));
  ExpectSpots(Read());
}

TEST_F(OpenMvgSet, PanoramasAndStepsWithoutPosesAreNamed) {
  Draw(
      scratch_ / "images", [](const Vector3d&) { return Vector2d(9, 9); }, 0);
  Write("sfm_data.json",
        Document(R"({"key": 0, "value": {"polymorphic_id": 2147483649, "polymorphic_name": "spherical",
"ptr_wrapper": {"id": 1, "data": {"value0": {"width": 240, "height": 120}}}}})"));
  EXPECT_THAT([&] { Read(); },
              ThrowsMessage<Error>(AllOf(HasSubstr("'spherical'"), HasSubstr("Undistorted"))));
  Write("sfm_data.json", R"({"sfm_data_version": "0.3", "root_path": "x", "views": [], "extrinsics": []})");
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("sfm_data.bin")));
}

// ---- VisualSFM ----

class VisualSfmSet : public test::DrawnSet {
 protected:
  std::string Rows(double r, bool with_matrices = false) const {
    std::string text;
    for (const DrawnCamera& camera : cameras_) {
      const Eigen::Quaterniond q(camera.cam_from_world);
      text += fmt::format("{}\t200 {} {} {:.17g} 0\n", camera.name,
                          with_matrices
                              ? Joined(camera.cam_from_world, " ")
                              : fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}", q.w(), q.x(), q.y(), q.z()),
                          Joined(with_matrices ? camera.Translation() : camera.center, " "), r);
    }
    return text;
  }
  // The measured point m (pixels from the middle) belongs to (1 + r |m / f|²) m (LoadNVM,
  // SetMeasurementDistortion).
  static Vector2d Measured(const Vector3d& p, double r) {
    const Vector2d straight = p.head<2>() / p.z();
    double distorted = straight.norm();
    for (int i = 0; i < 200; ++i) distorted = straight.norm() / (1 + r * distorted * distorted);
    return 200 * distorted * straight.normalized();
  }
  LightField Read() const { return ReadPosedSet(scratch_ / "model.nvm", {}, {}).light_field; }
};

TEST_F(VisualSfmSet, LensAndPointsOfTheLargestModelFit) {
  const double r = 0.11;
  Draw(
      scratch_.path(), [&](const Vector3d& p) { return Vector2d(Measured(p, r) + Vector2d(120, 90)); }, 0.5);
  std::string points;
  for (const Vector3d& point : points_) {
    points += Joined(point, " ") + " 1 2 3 5";
    for (std::size_t i = 0; i < 5; ++i) {
      const Vector2d m = Measured(cameras_[i].InCam(point), r);
      points += fmt::format(" {} 11 {:.9f} {:.9f}", i, m.x(), m.y());
    }
    points += "\n";
  }
  // A smaller model stands before it, and what was not registered behind.
  Write("model.nvm",
        "\xEF\xBB\xBF# mine\r\nNVM_V3\r\n\r\n1\r\nshot_0.png 90 1 0 0 0 0 0 0 0 0\r\n\r\n0\r\n\n5\n" +
            Rows(r) + fmt::format("\n{}\nnan 0 1 1 2 3 0\n", points_.size() + 1) + points +
            "\n1\nother 1.png\t0 0 0 0 0 0 0 0 0 0\n0\n\n0\n#the last part points to PLY files\n0\n");
  const LightField read = Read();
  ExpectSpots(read);
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("of 2 models the largest is read, with 5 cameras"),
                                       HasSubstr("1 point whose position is not finite: left out")));
  ASSERT_EQ(read.points.size(), points_.size());
  for (const ScenePoint& point : read.points) {
    EXPECT_EQ(point.track.size(), 5u);
    EXPECT_LT(point.error_px, 0.02);
  }
}

TEST_F(VisualSfmSet, MatricesAndFixedIntrinsicsFit) {
  Draw(
      scratch_.path(),
      [](const Vector3d& p) { return Vector2d(210 * p.x() / p.z() + 125, 205 * p.y() / p.z() + 87); }, 0.5);
  Write("model.nvm", "NVM_V3_R9T FixedK 210 125 205 87 0\n5\n" + Rows(0, true) + "0\n0\n");
  const LightField read = Read();
  ExpectSpots(read);
  EXPECT_THAT(read.doubts, ElementsAre(HasSubstr("whose size it does not say")));
  EXPECT_THAT(FormatsIn(scratch_.path()), ElementsAre(SetFormat::kVisualSfm));
}

TEST_F(VisualSfmSet, NamesMayBeQuoted) {
  for (DrawnCamera& camera : cameras_) camera.name = "a " + camera.name;
  Draw(
      scratch_.path(), [](const Vector3d& p) { return Vector2d(Measured(p, 0) + Vector2d(120, 90)); }, 0.5);
  for (DrawnCamera& camera : cameras_) camera.name = "\"" + camera.name + "\"";
  Write("model.nvm", "NVM_V3\n\n5\n" + Rows(0) + "0\n0\n");
  ExpectSpots(Read());
}

TEST_F(VisualSfmSet, ResizedPhotographsAreNamed) {
  Draw(scratch_.path(), [](const Vector3d&) { return Vector2d(9, 9); }, 0, {120, 90});
  Write("model.nvm", "NVM_V3\n\n5\n" + Rows(0) + "1\n1 2 3 1 2 3 2 0 5 -70 20 1 5 10 20\n0\n");
  EXPECT_THAT([&] { Read(); },
              ThrowsMessage<Error>(AllOf(HasSubstr("shot_0.png"), HasSubstr("that were measured"))));
  Write("model.nvm", "NVM_V3 FixedK 210 125 205 87 0\n5\n" + Rows(0) + "0\n0\n");
  EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(HasSubstr("principal point (125, 87)")));
}

TEST_F(VisualSfmSet, StrongLensesAndDamageAreNamed) {
  Draw(
      scratch_.path(), [](const Vector3d&) { return Vector2d(9, 9); }, 0);
  const auto expect = [&](const std::string& text, const std::string& words) {
    Write("model.nvm", text);
    EXPECT_THAT([&] { Read(); }, ThrowsMessage<Error>(AllOf(HasSubstr("model.nvm"), HasSubstr(words))));
  };
  expect("NVM_V3\n\n5\n" + Rows(40) + "0\n", "VisualSFM's radial distortion is not one of ours");
  expect("NVM_V3\n\n5\nshot_0.png 200 1 0 0 0 0 0 0 0 0\n", "ends before camera 2 of 5");
  expect("NVM_V3\n\n1\nshot_0.png 200 1 0 0 nan 0 0 0 0 0\n0\n", "line 4");
  expect("NVM_V3\n\n1\nshot_0.png 200 2 0 0 0 0 0 0 0 0\n0\n", "length 2");
  expect("NVM_V3\n\n2\n0\n0\n", "expected the name");
  expect("NVM_V3\n\n0\n", "no model");
  expect("NVM_V2\n", "NVM_V3");
}

}  // namespace
}  // namespace ulf::sfm_sets_test
