// Tests: commands/light_field/import_command, render/scene/scene, commands/options/scene_options.
//
// A set that looks outwards, from inside a drawn room: taken in without a subject, and then used.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/base/json_text.h"
#include "core/geometry/angles.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/support/test_paths.h"

namespace ulf::test::outward_set_test {
namespace {

using Eigen::Vector3d;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const Vector3d kHalfRoom(2.5, 1.8, 1.3);  // metres, from its middle; z is up
constexpr int kPhotographs = 24;

CameraModel Camera() { return CameraModel::Pinhole(96, 72, 60); }

// Returns where a ray from inside the room meets a wall.
Vector3d OnWall(const Vector3d& from, const Vector3d& ray) {
  double nearest = 1e9;
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(ray(axis)) > 1e-9)
      nearest = std::min(nearest, (std::copysign(kHalfRoom(axis), ray(axis)) - from(axis)) / ray(axis));
  return from + nearest * ray;
}

// Smooth, so that small errors of depth cost little, and nowhere the same.
cv::Vec3b ColorOf(const Vector3d& at) {
  const auto wave = [](double phase) { return static_cast<std::uint8_t>(128 + 100 * std::sin(phase)); };
  return {wave(1.3 * at.x() + 0.7 * at.y()), wave(1.1 * at.y() - 1.9 * at.z()), wave(2 * at.x() + at.z())};
}

cv::Mat Photograph(const Rigid3& cam_from_world) {
  const CameraModel camera = Camera();
  cv::Mat picture(camera.height, camera.width, CV_8UC3);
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d ray((x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1);
      picture.at<cv::Vec3b>(y, x) =
          ColorOf(OnWall(world_from_cam.translation, world_from_cam.rotation * ray));
    }
  return picture;
}

// On a circle of 30 cm in the room, above its middle, looking outwards and a little up or down.
Rigid3 OutwardPose(double share) {
  const double angle = 2 * M_PI * share;
  const Vector3d out(std::cos(angle), std::sin(angle), 0), middle(0, 0, 0.7);
  return LookAt(middle + 0.3 * out, middle + 2 * out + Vector3d(0, 0, 0.2 * std::sin(5 * angle)),
                Vector3d::UnitZ());
}

class OutwardSet : public ::testing::Test {
 protected:
  OutwardSet() {
    LightField set;
    set.cameras = {Camera()};
    std::filesystem::create_directories(set_ / "images");
    for (int i = 0; i < kPhotographs; ++i) {
      View& view = set.views.emplace_back();
      view.id = i + 1;
      view.image_path = fmt::format("images/{:02}.png", i);
      view.cam_from_world = OutwardPose(static_cast<double>(i) / kPhotographs);
      cv::imwrite((set_ / view.image_path).string(), Photograph(view.cam_from_world));
    }
    json document = TransformsDocument(set);
    document.erase("ulf");
    for (json& frame : document["frames"]) frame.erase("ulf");
    document["ply_file_path"] = "points.ply";
    std::ofstream(set_ / kTransformsFile) << JsonText(document);
    WritePoints();
  }

  // Points on the walls in all directions.
  void WritePoints() const {
    std::ofstream ply(set_ / "points.ply");
    constexpr int kPoints = 600;
    ply << "ply\nformat ascii 1.0\nelement vertex " << kPoints
        << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for (int i = 0; i < kPoints; ++i) {
      const double z = 1 - 2 * (i + 0.5) / kPoints, angle = 2.399963 * i, across = std::sqrt(1 - z * z);
      const Vector3d at = OnWall(Vector3d::Zero(), {across * std::cos(angle), across * std::sin(angle), z});
      ply << at.x() << ' ' << at.y() << ' ' << at.z() << '\n';
    }
  }

  CommandResult Import(const std::string& options) const {
    return RunUlf("import " + set_.string() + " --no-check -o " + dir_.string() + " " + options);
  }
  // Renders along a path and expects pictures that show what the room shows there.
  void ExpectPictures(const std::string& options, const std::vector<Rigid3>& truth) const {
    const std::filesystem::path out = scratch_ / "pictures";
    const CommandResult result =
        RunUlf("render " + dir_.string() + " --overwrite -o " + out.string() + " " + options);
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(result.errors, Not(HasSubstr("show nothing"))) << options;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const cv::Mat shown = cv::imread((out / fmt::format("frame_{:05}.png", i)).string());
      ASSERT_FALSE(shown.empty()) << options << ", picture " << i;
      EXPECT_GT(cv::PSNR(shown, Photograph(truth[i])), 27) << options << ", picture " << i;
    }
  }

  ScratchFolder scratch_;
  std::filesystem::path set_ = scratch_ / "set", dir_ = scratch_ / "lf";
};

TEST_F(OutwardSet, NeedsNoSubject) {
  const CommandResult refused = Import("");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("--no-subject"), HasSubstr("--subject x,y,z,radius")));
  EXPECT_FALSE(std::filesystem::exists(dir_));
  EXPECT_EQ(Import("--no-subject --subject 0,0,0,1").exit_code, 2);

  const CommandResult taken = Import("--no-subject");
  ASSERT_EQ(taken.exit_code, 0) << taken.errors;
  EXPECT_THAT(taken.output, HasSubstr("no subject"));
  const LightField made = ReadLightField(dir_);
  EXPECT_FALSE(made.subject);
  EXPECT_EQ(made.views.size(), std::size_t{kPhotographs});
  EXPECT_LT(AngleBetween(made.UpInWorld(), Vector3d::UnitZ()), Radians(1));
  const CommandResult told = RunUlf("info " + dir_.string());
  EXPECT_EQ(told.exit_code, 0);
  EXPECT_THAT(told.output, HasSubstr("without a subject"));
  const CommandResult copied =
      RunUlf("import " + dir_.string() + " --no-check -o " + (scratch_ / "copy").string());
  EXPECT_EQ(copied.exit_code, 0) << "a light field without a subject: " << copied.errors;
  EXPECT_EQ(RunUlf("export colmap " + dir_.string() + " --known-points -o " + (scratch_ / "colmap").string())
                .exit_code,
            0);
}

TEST_F(OutwardSet, IsRenderedAlongItsViewsAndBetween) {
  ASSERT_EQ(Import("--no-subject").exit_code, 0);
  std::vector<Rigid3> own, between;
  std::ofstream tum(scratch_ / "between.txt");
  for (int i = 0; i < kPhotographs; ++i) {
    own.push_back(OutwardPose(static_cast<double>(i) / kPhotographs));
    between.push_back(OutwardPose((i + 0.5) / kPhotographs));
    const Rigid3 pose = between.back().Inverse();
    tum << fmt::format("{} {} {} {} {} {} {} {}\n", i, pose.translation.x(), pose.translation.y(),
                       pose.translation.z(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z(),
                       pose.rotation.w());
  }
  tum.close();
  ExpectPictures("--proxy points --path " + dir_.string(), own);
  ExpectPictures("--path " + (scratch_ / "between.txt").string(), between);
  ExpectPictures("--proxy points --zoom 1 --path walk --frames 24", {own.front()});
}

TEST_F(OutwardSet, HasAnOrbitAboutItsPointsAndAViewer) {
  ASSERT_EQ(Import("--no-subject").exit_code, 0);
  ExpectPictures("--proxy points --path orbit --frames 3", {});
  std::vector<cv::Mat> around;
  for (int i = 0; i < 3; ++i) {
    around.push_back(cv::imread((scratch_ / fmt::format("pictures/frame_{:05}.png", i)).string()));
    ASSERT_FALSE(around.back().empty()) << i;
    cv::Mat dark;
    cv::inRange(around.back(), cv::Scalar::all(0), cv::Scalar::all(12), dark);  // the walls have from 28 on
    EXPECT_LT(cv::countNonZero(dark), 0.02 * static_cast<double>(dark.total())) << i;
  }
  EXPECT_GT(cv::norm(around[0], around[1], cv::NORM_L1) / static_cast<double>(around[0].total()), 30);
  const CommandResult view =
      RunUlf("view " + dir_.string() + " --width 96 --height 72 --keys t,w --screenshot " +
             (scratch_ / "view.png").string());
  ASSERT_EQ(view.exit_code, 0) << view.errors;
  const cv::Mat shown = cv::imread((scratch_ / "view.png").string());
  ASSERT_FALSE(shown.empty());
  EXPECT_GT(cv::PSNR(shown, Photograph(OutwardPose(0.5))), 25) << "it begins at the middle view";
}

}  // namespace
}  // namespace ulf::test::outward_set_test
