// Tests: render/output/camera_path, render/output/path_files, render/output/keyframes.
#include "render/output/camera_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>
#include <map>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "render/gl/gl_renderer.h"
#include "render/output/keyframes.h"
#include "render/output/path_files.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::camera_path_test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing::HasSubstr;

test::SceneSpec SmallSpec() { return {.viewpoints = test::GridViewpoints(6, 5, 0.2, 2.0)}; }

TEST(CameraPath, OrbitStaysInTheHullFacingTheSubject) {
  for (const auto& viewpoints :
       {test::GridViewpoints(6, 5, 0.2, 2.0), test::CapViewpoints(80, 0.7, 2.0, 0.05)}) {
    const auto scene = test::MakeScene({.viewpoints = viewpoints, .width = 8, .height = 8});
    const CameraPath path = OrbitPath(*scene, 24);
    ASSERT_EQ(path.cam_from_world.size(), 24u);
    double widest = 0;
    for (const Rigid3& pose : path.cam_from_world) {
      EXPECT_TRUE(InsideHull(scene->mesh, pose.OriginInSource()));
      const Vector3d subject_in_cam = pose * scene->subject.center_in_world;
      EXPECT_LT(subject_in_cam.head<2>().norm(), 1e-9 * subject_in_cam.z());
      widest = std::max(widest, pose.OriginInSource().head<2>().norm());
    }
    EXPECT_GT(widest, 0.2);
  }
}

TEST(CameraPath, OrbitGoesAllTheWayRoundARing) {
  auto viewpoints = test::RingViewpoints(40, 0.2, 2.0);
  for (Vector3d& c : viewpoints) c = Vector3d(c.x(), c.z(), c.y());  // around y, which is up
  const auto scene = test::MakeScene({.viewpoints = viewpoints, .width = 8, .height = 8});
  const CameraPath path = OrbitPath(*scene, 36);
  Vector3d sum = Vector3d::Zero();
  for (const Rigid3& pose : path.cam_from_world) sum += pose.OriginInSource();
  sum /= 36;
  EXPECT_LT(std::hypot(sum.x(), sum.z()), 0.05);
  EXPECT_NEAR(sum.y(), 2 * std::sin(0.2), 0.05);
}

TEST(CameraPath, DollyHalvesTheDistance) {
  const auto scene = test::MakeScene(SmallSpec());
  const CameraPath path = DollyPath(*scene, 10);
  const double first = path.cam_from_world.front().OriginInSource().norm();
  EXPECT_NEAR(path.cam_from_world.back().OriginInSource().norm(), 0.5 * first, 1e-9);
}

// Cameras rolled by a third of a right angle: from between them corners are uncovered until zoomed in.
TEST(CameraPath, ZoomFillsThePictures) {
  auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(6, 5, 0.2, 2.0)});
  const CameraModel camera = scene->views.front().camera;
  for (SceneView& view : scene->views) {
    const Eigen::Quaterniond roll(Eigen::AngleAxisd(M_PI / 6, Vector3d::UnitZ()));
    view.cam_from_world.rotation = roll * view.cam_from_world.rotation;
    view.cam_from_world.translation = roll * view.cam_from_world.translation;
  }
  const auto renderer = MakeRenderer(scene, {.renderer = RendererKind::kReference});
  const CameraPath path = OrbitPath(*scene, 6);
  const auto uncovered = [&](double zoom) {
    CameraModel zoomed = camera;
    zoomed.fx *= zoom;
    zoomed.fy *= zoom;
    const Rendering picture = renderer->Render(zoomed, path.cam_from_world[2]);
    return static_cast<double>(picture.filled_px + picture.empty_px) /
           static_cast<double>(picture.linear.total());
  };
  const FillingLens filling = FillingZoom(*renderer, path, camera);
  EXPECT_GT(filling.zoom, 1.1);
  EXPECT_LE(filling.zoom, 1.6);
  EXPECT_GT(uncovered(1), 0.02);
  EXPECT_LT(uncovered(filling.zoom), 0.01);
}

// What stays black at the zoom is told, and nothing does where nothing is told.
TEST(CameraPath, ZoomTellsWhatStaysBlack) {
  for (const double roll_angle : {0.0, M_PI / 24, M_PI / 4}) {
    auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(6, 5, 0.2, 2.0)});
    const CameraModel camera = scene->views.front().camera;
    for (SceneView& view : scene->views) {
      const Eigen::Quaterniond roll(Eigen::AngleAxisd(roll_angle, Vector3d::UnitZ()));
      view.cam_from_world.rotation = roll * view.cam_from_world.rotation;
      view.cam_from_world.translation = roll * view.cam_from_world.translation;
    }
    const auto renderer = MakeRenderer(scene, {});
    const CameraPath path = OrbitPath(*scene, 6);
    const FillingLens filling = FillingZoom(*renderer, path, camera);
    double black = 0;
    for (const Rigid3& pose : path.cam_from_world) {
      CameraModel zoomed = camera.ScaledTo(120, 90);
      zoomed.fx *= filling.zoom;
      zoomed.fy *= filling.zoom;
      const Rendering picture = renderer->Render(zoomed, pose);
      black = std::max(black,
                       static_cast<double>(picture.empty_px) / static_cast<double>(picture.linear.total()));
    }
    EXPECT_NEAR(black, filling.black_at_worst, 1e-4) << roll_angle;
  }
}

TEST(CameraPath, TumFilesAreReadAndFaultsNamed) {
  test::ScratchFolder scratch;
  std::ofstream(scratch / "good.txt")
      << "# time tx ty tz qx qy qz qw\n0.0 1 2 3 0 0 0 1\n0.1 1 2 4 0 1 0 0\n";
  const CameraPath path = PathFromFile(scratch / "good.txt", {}, {});
  ASSERT_EQ(path.cam_from_world.size(), 2u);
  EXPECT_LT((path.cam_from_world[1].OriginInSource() - Vector3d(1, 2, 4)).norm(), 1e-12);
  EXPECT_LT((path.cam_from_world[1].DirectionInSource(Vector3d::UnitZ()) + Vector3d::UnitZ()).norm(), 1e-12);

  std::ofstream(scratch / "bad.txt") << "0.0 1 2 3 0 0 0 1\n0.1 1 2 four 0 0 0 1\n";
  std::ofstream(scratch / "zero.txt") << "0.0 1 2 3 0 0 0 1\n\n0.1 1 2 3 0 0 0 0\n";
  std::ofstream(scratch / "empty.txt") << "# nothing\n";
  for (const auto& [name, says] : {std::pair{"bad.txt", "bad.txt:2: expected eight numbers"},
                                   {"zero.txt", "zero.txt:3: not a pose"},
                                   {"empty.txt", "no pose"},
                                   {"none.txt", "no such"}}) {
    const std::filesystem::path file = scratch / name;
    EXPECT_THAT([&] { PathFromFile(file, {}, {}); }, testing::ThrowsMessage<Error>(HasSubstr(says))) << file;
  }
}

TEST(CameraPath, WalkPassesThroughTheViews) {
  const auto scene =
      test::MakeScene({.viewpoints = test::GridViewpoints(6, 5, 0.2, 2.0), .width = 8, .height = 8});
  const std::size_t views = scene->views.size();
  const CameraPath path = WalkPath(*scene, 24);
  ASSERT_EQ(path.cam_from_world.size(), 24u);
  const auto differ = [](const Rigid3& a, const Rigid3& b) { return (a.Matrix() - b.Matrix()).norm(); };
  EXPECT_LT(differ(path.cam_from_world.front(), scene->views.front().cam_from_world), 1e-9);
  EXPECT_LT(differ(path.cam_from_world.back(), scene->views.back().cam_from_world), 1e-9);
  EXPECT_LT(differ(path.cam_from_world[12], scene->views[12 * (views - 1) / 23].cam_from_world), 1e-9);
  auto alone = *scene;
  alone.views.resize(1);
  EXPECT_LT(differ(WalkPath(alone, 3).cam_from_world[2], scene->views.front().cam_from_world), 1e-9);
}

// ---- Vertigo and spiral ----

// A white disc of radius 0.25 in the plane through the subject's centre, before black.
cv::Mat PhotographOfDisc(const CameraModel& camera, const Rigid3& cam_from_world) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  cv::Mat picture(camera.height, camera.width, CV_8UC3, cv::Scalar::all(0));
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d ray = world_from_cam.rotation * *camera.RayFromImg({x + 0.5, y + 0.5});
      const Vector3d point = world_from_cam.translation - world_from_cam.translation.z() / ray.z() * ray;
      if (point.norm() < 0.25) picture.at<cv::Vec3b>(y, x) = {255, 255, 255};
    }
  return picture;
}

TEST(CameraPath, VertigoKeepsTheSubjectsSize) {
  const auto scene = test::MakeScene(
      {.viewpoints = test::GridViewpoints(6, 5, 0.1, 2.0), .width = 192, .height = 144, .focal_px = 240});
  for (SceneView& view : scene->views)
    view.photograph = test::HoldPhotograph(MakePyramid(PhotographOfDisc(view.camera, view.cam_from_world)));
  const CameraModel camera = CameraModel::Pinhole(200, 150, 250);
  const CameraPath path = VertigoPath(*scene, 5, camera);
  ASSERT_EQ(path.cameras.size(), 5u);
  EXPECT_EQ(path.cameras.front(), camera);
  EXPECT_NEAR(path.cameras.back().fx, 125, 1e-9);
  const auto renderer = MakeRenderer(scene, {.renderer = RendererKind::kReference});
  std::vector<double> sizes;
  for (std::size_t i = 0; i < 5; ++i) {
    const Rendering picture = renderer->Render(path.cameras[i], path.cam_from_world[i]);
    sizes.push_back(std::sqrt(cv::sum(picture.linear)[1] / M_PI));  // the disc's radius in pixels
  }
  EXPECT_LT(path.cam_from_world.back().OriginInSource().norm(),
            0.51 * path.cam_from_world.front().OriginInSource().norm());
  EXPECT_NEAR(sizes.front(), 250 * 0.25 / 2.0, 0.75);
  for (const double size : sizes) EXPECT_NEAR(size / sizes.front(), 1, 0.005);
}

TEST(CameraPath, SpiralMakesThreeTurnsInsideTheHull) {
  for (const auto& viewpoints :
       {test::GridViewpoints(6, 5, 0.2, 2.0), test::CapViewpoints(80, 0.7, 2.0, 0.05)}) {
    const auto scene = test::MakeScene({.viewpoints = viewpoints, .width = 8, .height = 8});
    const CameraPath path = SpiralPath(*scene, 90);
    double turned = 0, widest = 0;
    Vector3d before = Vector3d::Zero();
    for (const Rigid3& pose : path.cam_from_world) {
      const Vector3d center = pose.OriginInSource();
      EXPECT_TRUE(InsideHull(scene->mesh, center));
      const Vector3d off(center.x(), center.y(), 0);
      if (off.norm() > 0.02 && before.norm() > 0.02)
        turned += std::abs(std::atan2(before.cross(off).z(), before.dot(off)));
      before = off;
      widest = std::max(widest, off.norm());
    }
    EXPECT_GT(widest, 0.2);
    EXPECT_NEAR(turned / (2 * M_PI), 2.8, 0.35);  // without what is near the middle
  }
}

TEST(CameraPath, SpiralClimbsWhereViewsStandAllAround) {
  auto viewpoints = test::CapViewpoints(150, M_PI, 2.0);
  const auto scene = test::MakeScene({.viewpoints = viewpoints, .width = 8, .height = 8});
  const CameraPath path = SpiralPath(*scene, 60);
  const double lowest = path.cam_from_world.front().OriginInSource().y(),
               highest = path.cam_from_world[30].OriginInSource().y();
  EXPECT_LT(lowest, -1.0);
  EXPECT_GT(highest, 1.0);
}

TEST(CameraPath, RiseCrossesTheRowsAndSweepGoesAlongOne) {
  const auto scene =
      test::MakeScene({.viewpoints = test::GridViewpoints(6, 5, 0.2, 2.0), .width = 8, .height = 8});
  for (const bool rises : {true, false}) {
    const CameraPath path = rises ? RisePath(*scene, 80) : SweepPath(*scene, 80);
    ASSERT_EQ(path.cam_from_world.size(), 80u);
    Vector3d low = path.cam_from_world.front().OriginInSource(), high = low;
    for (const Rigid3& pose : path.cam_from_world) {
      EXPECT_TRUE(InsideHull(scene->mesh, pose.OriginInSource()));
      low = low.cwiseMin(pose.OriginInSource());
      high = high.cwiseMax(pose.OriginInSource());
    }
    const Vector3d extent = high - low;
    EXPECT_GT(rises ? extent.y() : extent.x(), 0.4);
    EXPECT_LT(rises ? extent.x() : extent.y(), 0.05);
    EXPECT_LT((path.cam_from_world[79].OriginInSource() - path.cam_from_world[0].OriginInSource()).norm(),
              0.02)
        << "it comes back";
  }
}

// ---- Keyframes ----

TEST(Keyframes, SplineIsSmoothAndMeetsItsPoints) {
  Eigen::MatrixXd values(5, 2);
  values << 0, 1, 2, -1, 1, 3, 4, 4, 3, 0;
  const std::vector<double> times{0, 0.5, 2, 2.2, 4};
  const CubicSpline spline(times, values);
  constexpr double h = 1e-4;
  const auto second = [&](double t) -> Eigen::VectorXd {
    return (spline.At(t + h) - 2 * spline.At(t) + spline.At(t - h)) / (h * h);
  };
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_LT((spline.At(times[i]) - values.row(static_cast<Eigen::Index>(i)).transpose()).norm(), 1e-12);
    if (i == 0 || i + 1 == times.size()) continue;
    const double t = times[i];
    const Eigen::VectorXd left = (spline.At(t - h) - spline.At(t - 2 * h)) / h,
                          right = (spline.At(t + 2 * h) - spline.At(t + h)) / h;
    EXPECT_LT((right - left).norm(), 0.05) << "velocity at " << t;
    EXPECT_LT((second(t - 2 * h) - second(t + 2 * h)).norm(), 0.1) << "acceleration at " << t;
  }
  EXPECT_LT(second(times.front() + h).norm(), 0.1);  // natural
}

TEST(Keyframes, TurnsGoTheShortWayAndZoomsAtAnEvenSpeed) {
  const auto turned = [](double degrees, double sign) {
    Quaterniond q(Eigen::AngleAxisd(degrees * M_PI / 180, Vector3d::UnitY()));
    q.coeffs() *= sign;
    return q;
  };
  const std::vector<PathKeyframe> keys{
      {.time_s = 0, .world_from_cam = turned(0, 1), .focal_px = 100},
      {.time_s = 1, .eye_in_world = {1, 0, 0}, .world_from_cam = turned(30, -1), .focal_px = 200},
      {.time_s = 2, .eye_in_world = {2, 0, 0}, .world_from_cam = turned(60, 1), .focal_px = 400}};
  const auto poses = InterpolateKeyframes(keys, 21);
  ASSERT_EQ(poses.size(), 21u);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double s = static_cast<double>(i) / 20;
    const Vector3d forward = poses[i].cam_from_world.DirectionInSource(Vector3d::UnitZ());
    EXPECT_NEAR(std::atan2(forward.x(), forward.z()) * 180 / M_PI, 60 * s, 1.0) << i;
    EXPECT_LT((poses[i].cam_from_world.OriginInSource() - Vector3d(2 * s, 0, 0)).norm(), 1e-9) << i;
    EXPECT_NEAR(poses[i].focal_px, 100 * std::pow(4, s), 1e-6) << i;
  }
}

TEST(Keyframes, WithTargetsTheSubjectStaysInTheMiddle) {
  std::vector<PathKeyframe> keys;
  for (const Vector3d& eye : {Vector3d(0, 0, 2), Vector3d(1, 0.5, 1), Vector3d(1.5, 0, -1)})
    keys.push_back({.time_s = static_cast<double>(keys.size()),
                    .eye_in_world = eye,
                    .target_in_world = Vector3d(0.1, 0, 0)});
  for (const KeyframedPose& pose : InterpolateKeyframes(keys, 30)) {
    const Vector3d in_cam = pose.cam_from_world * Vector3d(0.1, 0, 0);
    EXPECT_LT(in_cam.head<2>().norm(), 1e-9);
    EXPECT_GT(in_cam.z(), 0);
  }
}

// ---- JSON files ----

class PathFiles : public testing::Test {
 protected:
  CameraPath Read(const std::string& text, int frames = 0, const std::string& light_field = "") {
    std::ofstream(scratch_ / "path.json") << text;
    return PathFromFile(scratch_ / "path.json",
                        {.frames = frames,
                         .camera = CameraModel::Pinhole(200, 100, 150),
                         .fps = 10,
                         .light_field = light_field},
                        scene_);
  }
  void ExpectError(const std::string& text, const std::string& says) {
    EXPECT_THAT([&] { Read(text); },
                testing::ThrowsMessage<Error>(testing::AllOf(HasSubstr("path.json"), HasSubstr(says))))
        << text;
  }
  test::ScratchFolder scratch_;
  RenderScene scene_;
};

TEST_F(PathFiles, KeyframesAreReadAndSampledByTheirTimes) {
  const CameraPath path = Read(R"({"width": 400, "height": 300, "keyframes": [
      {"time": 1, "eye": [0, 0, 2], "target": [0, 0, 0], "up": [0, 1, 0], "focal_px": 300},
      {"time": 3, "eye": [0, 0, 1], "rotation": [0, 1, 0, 0], "fov_deg": 90}]})");
  ASSERT_EQ(path.cam_from_world.size(), 21u);  // two seconds at ten a second
  EXPECT_EQ(path.cameras.front().width, 400);
  EXPECT_EQ(path.cameras.front().height, 300);
  EXPECT_NEAR(path.cameras.front().fx, 300, 1e-9);
  EXPECT_NEAR(path.cameras.back().fx, 200, 1e-9);  // 400 pixels wide at 90 degrees
  EXPECT_LT((path.cam_from_world.front().OriginInSource() - Vector3d(0, 0, 2)).norm(), 1e-12);
  EXPECT_LT((path.cam_from_world.back().OriginInSource() - Vector3d(0, 0, 1)).norm(), 1e-12);
  for (const Rigid3& pose : path.cam_from_world)  // both look along -z
    EXPECT_LT((pose.DirectionInSource(Vector3d::UnitZ()) + Vector3d::UnitZ()).norm(), 1e-9);
  const CameraPath asked = Read(R"({"keyframes": [{"time": 0, "eye": [0,0,2], "target": [0,0,0]},
                                                 {"time": 1, "eye": [0,1,2], "target": [0,0,0]}]})",
                                7);
  ASSERT_EQ(asked.cameras.size(), 7u);
  EXPECT_EQ(asked.cameras[6].width, 200);
  EXPECT_NEAR(asked.cameras[6].fx, 150, 1e-9);
}

TEST_F(PathFiles, FaultyKeyframesAreNamed) {
  ExpectError(R"({"keyframes": []})", "no pose");
  ExpectError(R"({"keyframes": 3})", "'keyframes' must be a list");
  ExpectError(R"({"keyframes": [{"time": 0, "target": [0,0,0]}]})", "keyframe 0: the key 'eye'");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,1], "rotation": [0,0,0,0]}]})",
              "'rotation' must be a unit quaternion");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,1], "target": [0,0,1]}]})", "the same point");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,1], "target": [0,0,0], "up": [0,0,3]}]})",
              "'up' points along the view");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,1]}]})", "either 'target'");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,NaN], "target": [0,0,0]}]})",
              "keyframe 0: 'eye' holds \"NaN\", which is not a finite number");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,1e999], "target": [0,0,0]}]})", "path.json");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,1], "target": [0,0,0], "focal_px": 100}]})",
              "'width' and 'height'");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,1], "target": [0,0,0], "fov_deg": 180}]})",
              "'fov_deg'");
  ExpectError(R"({"keyframes": [{"time": 1, "eye": [0,0,1], "target": [0,0,0]},
                                {"time": 1, "eye": [0,0,2], "target": [0,0,0]}]})",
              "keyframe 1: 'time' must be later");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,1], "target": [0,0,0]},
                                {"time": 1e9, "eye": [0,0,2], "target": [0,0,0]}]})",
              "in seconds");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,1], "target": [0,0,0]},
                                {"time": 1, "eye": [0,0,-1], "target": [0,0,0]}]})",
              "meets its target");
  ExpectError(R"({"poses": []})", "neither 'keyframes'");
  ExpectError(R"({"keyframes": [{"time": 0, "eye": [0,0,1], "target": [0,0,0], "fvo_deg": 20}]})",
              "no key 'fvo_deg'; there are time, eye");
  ExpectError(R"({"widht": 64, "keyframes": [{"time": 0, "eye": [0,0,1], "target": [0,0,0]}]})",
              "no key 'widht'");
}

// A camera at (1, 2, 3) of nerfstudio's world, its axes turned a quarter about z: OpenGL's x, y and z axes
// are the columns (0, 1, 0), (-1, 0, 0) and (0, 0, 1), so ours (x right, y down, z forward) are (0, 1, 0),
// (1, 0, 0) and (0, 0, -1).
constexpr const char* kNerfstudioPath = R"({
  "keyframes": [{"matrix": "of the viewer's own"}], "camera_type": "perspective",
  "render_width": 800, "render_height": 600, "fps": 24, "seconds": 1, "is_cycle": false,
  "camera_path": [
    {"camera_to_world": [0, -1, 0, 1,  1, 0, 0, 2,  0, 0, 1, 3,  0, 0, 0, 1], "fov": 90, "aspect": 1.333},
    {"camera_to_world": [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 4], [0, 0, 0, 1]], "fov": 53.13010235415598}]})";

TEST_F(PathFiles, NerfstudiosCameraPathIsRead) {
  const CameraPath path = Read(kNerfstudioPath);
  ASSERT_EQ(path.cam_from_world.size(), 2u);
  const Rigid3& pose = path.cam_from_world[0];
  EXPECT_LT((pose.OriginInSource() - Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((pose.DirectionInSource(Vector3d::UnitX()) - Vector3d(0, 1, 0)).norm(), 1e-12);
  EXPECT_LT((pose.DirectionInSource(Vector3d::UnitY()) - Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((pose.DirectionInSource(Vector3d::UnitZ()) - Vector3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_LT((path.cam_from_world[1].OriginInSource() - Vector3d(1, 2, 4)).norm(), 1e-12);
  // The field of view is the vertical one: 600 rows at 90 degrees, and at twice the arc tangent of a half.
  EXPECT_EQ(path.cameras[0].width, 800);
  EXPECT_EQ(path.cameras[0].height, 600);
  EXPECT_NEAR(path.cameras[0].fx, 300, 1e-9);
  EXPECT_NEAR(path.cameras[1].fy, 600, 1e-9);
  EXPECT_EQ(path.cameras[0].cx, 400);
}

// The run says: trained = 0.5 (R p + t) with R a quarter turn about x, (x, y, z) -> (x, -z, y), and
// t = (1, 0, 0). So (1, 2, 3) was (2, 4, 6) before the scale, (1, 4, 6) before t, (1, 6, -4) before R.
TEST_F(PathFiles, NerfstudiosTrainingWorldIsUndone) {
  std::ofstream(scratch_ / "dataparser_transforms.json")
      << R"({"transform": [[1,0,0,1],[0,0,-1,0],[0,1,0,0]], "scale": 0.5})";
  const CameraPath path = Read(kNerfstudioPath);
  EXPECT_LT((path.cam_from_world[0].OriginInSource() - Vector3d(1, 6, -4)).norm(), 1e-12);
  // Forward was (0, 0, -1): R takes (0, -1, 0) there.
  EXPECT_LT((path.cam_from_world[0].DirectionInSource(Vector3d::UnitZ()) - Vector3d(0, -1, 0)).norm(), 1e-12);

  // The set itself had been turned by ns-process-data, (x, y, z) -> (y, x, -z), before it was written.
  std::ofstream(scratch_ / "transforms.json")
      << R"({"frames": [], "applied_transform": [[0,1,0,0],[1,0,0,0],[0,0,-1,0]]})";
  const CameraPath applied = Read(kNerfstudioPath, 0, scratch_.path().string());
  EXPECT_LT((applied.cam_from_world[0].OriginInSource() - Vector3d(6, 1, 4)).norm(), 1e-12);
}

// One camera each, 3 before the origin, of 200 px; the longer side has 400 px.
TEST_F(PathFiles, SetsOfOtherProgramsAreGivenByTheirFiles) {
  const std::map<std::string, std::string> files{
      {"cameras.sfm", R"({"version": ["1", "2", "6"], "views": [{"viewId": "1", "poseId": "1",
"intrinsicId": "2", "path": "/else/a.jpg"}], "intrinsics": [{"intrinsicId": "2", "width": "400",
"height": "300", "sensorWidth": "36", "sensorHeight": "27", "type": "pinhole", "focalLength": "18",
"pixelRatio": "1", "principalPoint": ["0", "0"]}], "poses": [{"poseId": "1", "pose": {"transform":
{"rotation": ["1", "0", "0", "0", "1", "0", "0", "0", "1"], "center": ["0", "0", "-3"]}}}]})"},
      {"reconstruction.json", R"([{"cameras": {"c": {"projection_type": "perspective", "width": 400,
"height": 300, "focal": 0.5, "k1": 0, "k2": 0}}, "shots": {"a.jpg": {"rotation": [0, 0, 0],
"translation": [0, 0, 3], "camera": "c"}}, "points": {}}])"},
      {"sfm_data.json", R"({"sfm_data_version": "0.3", "root_path": "/else", "views": [{"key": 0, "value":
{"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 1, "data": {"local_path": "", "filename": "a.jpg",
"width": 400, "height": 300, "id_view": 0, "id_intrinsic": 0, "id_pose": 0}}}}], "intrinsics": [{"key": 0,
"value": {"polymorphic_id": 2147483649, "polymorphic_name": "pinhole", "ptr_wrapper": {"id": 2, "data":
{"width": 400, "height": 300, "focal_length": 200, "principal_point": [199.5, 149.5]}}}}],
"extrinsics": [{"key": 0, "value": {"rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "center": [0, 0, -3]}}],
"structure": []})"},
      {"cameras.json", R"([{"id": 0, "img_name": "a", "width": 400, "height": 300, "position": [0, 0, -3],
"rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "fx": 200, "fy": 200}])"}};
  for (const auto& [name, text] : files) {
    std::ofstream(scratch_ / name) << text;
    const CameraPath path = PathFromFile(scratch_ / name, {}, scene_);
    ASSERT_EQ(path.cameras.size(), 1u) << name;
    EXPECT_EQ(path.cameras[0].width, 400) << name;
    EXPECT_NEAR(path.cameras[0].fx, 200, 1e-9) << name;
    EXPECT_LT((path.cam_from_world.at(0).Matrix() - Rigid3{{1, 0, 0, 0}, {0, 0, 3}}.Matrix()).norm(), 1e-12)
        << name;
  }
}

TEST_F(PathFiles, FaultyNerfstudioPathsAreNamed) {
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = kNerfstudioPath;
    return text.replace(text.find(from), from.size(), to);
  };
  ExpectError(with("\"perspective\"", "\"equirectangular\""), "only perspective");
  ExpectError(with("800", "0"), "'render_width'");
  ExpectError(with("\"fov\": 90", "\"fov\": 0"), "camera_path 0: 'fov'");
  ExpectError(with("[0, -1, 0, 1,  1", "[0, -2, 0, 1,  1"), "camera_path 0: the upper left");
  ExpectError(with("0, 0, 1, 3,", "0, 0, 3,"), "must hold 16 numbers");
  ExpectError(with("[0, -1, 0, 1,  1", "[null, -1, 0, 1,  1"), "not a finite number");
  ExpectError(R"({"camera_path": [], "render_width": 8, "render_height": 6})", "no pose");
}

}  // namespace
}  // namespace ulf::camera_path_test
