// Tests: coverage/operator/marker_mouse, commands/capture/capture_command, render/quality/nearest_view.
//
// Captures with poses from markers and from outside, and a look round the result with a marker as a mouse.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fmt/core.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "coverage/operator/marker_mouse.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/quality/nearest_view.h"
#include "render/quality/quality.h"
#include "render/renderer/renderer.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::pose_source_capture_test {
namespace {

using test::RunUlf;
using ::testing::HasSubstr;

constexpr const char* kBoardOfEasel = "aruco:3x4:45:9:DICT_4X4_50";

// The board's frame and its metre are the light field's; then it is looked round with a marker.
TEST(PoseSourceCapture, MarkersGiveMetresAndThenTheView) {
  test::ScratchFolder scratch;
  const std::string dir = (scratch / "field").string();
  // The subject, 33 cm to the right of the easel's board, in the board's own frame.
  const StandingBoard board = *Scene::Named("easel")->board();
  const Eigen::Vector3d subject = board.board_from_world * Eigen::Vector3d(0, 0, 0.07);
  const auto captured =
      RunUlf(fmt::format("capture --no-geometry 'sim:easel?look_away=0' -o {} --headless --deterministic "
                         "--quality fast --frames 60 --json "
                         "--poses features+markers:{} --subject {},{},{},0.162",
                         dir, kBoardOfEasel, subject.x(), subject.y(), subject.z()));
  ASSERT_EQ(captured.exit_code, 0) << captured.errors;
  const LightField light_field = ReadLightField(dir);
  EXPECT_EQ(light_field.units, "metres");
  ASSERT_GE(light_field.views.size(), 3u);
  const SimulatedCamera camera(SimulationOptions::FromUri(DeviceUri::Parse("sim:easel?look_away=0")));
  for (const View& view : light_field.views) {
    const Eigen::Vector3d truth =
        board.board_from_world * camera.hand().CamFromWorld(view.device_time_s).OriginInSource();
    EXPECT_LT((view.CenterInWorld() - truth).norm(), 0.012) << "view " << view.id;
  }

  const std::string pictures = (scratch / "pictures").string();
  const auto looked = RunUlf(
      fmt::format("review {} 'sim:board?board=charuco:5x5:36:27:DICT_APRILTAG_36h11&stops=3' --markers "
                  "charuco:5x5:36:27:DICT_APRILTAG_36h11 -o {} --width 320 --height 240 --frames 20 --json",
                  dir, pictures));
  ASSERT_EQ(looked.exit_code, 0) << looked.errors;
  const auto report = JsonFromText(looked.output);
  EXPECT_EQ(report["frames"], 20);
  EXPECT_GT(report["with_marker"], 12);
  const cv::Mat last = cv::imread(pictures + "/frame_00019.png");
  ASSERT_EQ(last.size(), cv::Size(320, 240));
  EXPECT_GT(cv::mean(last)[1], 10) << "something is drawn";

  const auto unseen = RunUlf(fmt::format(
      "review {} sim:card --markers marker:80:DICT_APRILTAG_36h11:3 -o {} --frames 3", dir, pictures));
  EXPECT_EQ(unseen.exit_code, 1);
  EXPECT_THAT(unseen.errors, HasSubstr("never seen"));

  const auto elsewhere = RunUlf(fmt::format("review {} sim:card --markers dots -o {}", dir, pictures));
  EXPECT_EQ(elsewhere.exit_code, 2);
}

// Another day, with the map made anew from the recorded views: what is recorded then is in the board's frame
// and metre as before, and what was recorded has not moved.
TEST(PoseSourceCapture, GoesOnInTheBoardsFrame) {
  test::ScratchFolder scratch;
  const std::string dir = (scratch / "field").string();
  const std::string device = "sim:easel?look_away=0&fps=10";
  const StandingBoard board = *Scene::Named("easel")->board();
  const Eigen::Vector3d subject = board.board_from_world * Eigen::Vector3d(0, 0, 0.07);
  const auto capture = [&](const std::string& poses, int frames, const std::string& rest) {
    return RunUlf(fmt::format(
        "capture --no-geometry '{}' -o {} --headless --deterministic --frames {} --json --poses {} {}",
        device, dir, frames, poses, rest));
  };
  const std::string poses = fmt::format("features+markers:{}", kBoardOfEasel);
  const auto first =
      capture(poses, 36,
              fmt::format("--quality fast --subject {},{},{},0.162", subject.x(), subject.y(), subject.z()));
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  const LightField before = ReadLightField(dir);
  ASSERT_GE(before.views.size(), 3u);
  ASSERT_TRUE(std::filesystem::exists(scratch / "field/cache/map.ulf"));
  std::filesystem::remove(scratch / "field/cache/map.ulf");
  const auto second = capture(poses, 62, "--resume");
  ASSERT_EQ(second.exit_code, 0) << second.errors;
  EXPECT_THAT(second.errors, HasSubstr("the map is made again"));
  const LightField after = ReadLightField(dir);
  EXPECT_GT(after.views.size(), before.views.size());
  EXPECT_EQ(after.units, "metres");
  const SimulatedCamera camera(SimulationOptions::FromUri(DeviceUri::Parse(device)));
  for (std::size_t i = 0; i < after.views.size(); ++i) {
    const View& view = after.views[i];
    const Eigen::Vector3d truth =
        board.board_from_world * camera.hand().CamFromWorld(view.device_time_s).OriginInSource();
    EXPECT_LT((view.CenterInWorld() - truth).norm(), 0.008) << "view " << view.id;
    if (i >= before.views.size()) continue;
    EXPECT_LT((view.CenterInWorld() - before.views[i].CenterInWorld()).norm(), 1e-9) << "view " << view.id;
  }
  // The map that this session leaves behind is in the board's frame, too; and a board alone goes on as well.
  const auto third = capture(poses, 3, "--resume");
  ASSERT_EQ(third.exit_code, 0) << third.errors;
  EXPECT_THAT(third.errors, HasSubstr("the map of the last session was loaded"));
  const auto alone = capture(fmt::format("markers:{}", kBoardOfEasel), 3, "--resume");
  EXPECT_EQ(alone.exit_code, 0) << alone.errors;
  const auto several = capture("markers:marker:45:DICT_4X4_50", 3, "--resume");
  EXPECT_EQ(several.exit_code, 2);
  EXPECT_THAT(several.errors, HasSubstr("name the marker of the session before"));
}

// Views round a subject, each a plain colour: which one is shown, and that it lies where the reference has
// it.
TEST(NearestView, AgreesWithTheReference) {
  SimulationOptions options;
  options.width = 160;
  options.height = 120;
  const SimulatedCamera camera(options);
  RenderScene scene;
  scene.subject = camera.scene().subject();
  scene.up_in_world = Eigen::Vector3d::UnitZ();
  for (int i = 0; i < 5; ++i) {
    SceneView view;
    view.id = i + 1;
    view.camera = camera.camera();
    view.cam_from_world = camera.hand().CamFromWorld(0.9 * i);
    view.center_in_world = view.cam_from_world.OriginInSource();
    view.photograph = test::HoldPhotograph(MakePyramid(camera.CleanSrgb(view.cam_from_world)));
    scene.views.push_back(view);
  }
  scene.proxy = std::make_shared<PlaneProxy>(scene.subject);
  const NearestViewRenderer nearest(scene);
  const auto shared = std::make_shared<RenderScene>(scene);
  const auto reference =
      MakeRenderer(shared, {.field = {.kind = FieldKind::kNearest}, .renderer = RendererKind::kReference});
  const CameraModel virtual_camera = CameraModel::Pinhole(160, 120, 140);
  for (int i = 0; i < 5; ++i) {
    cv::Mat drawn;
    const Rigid3 pose = camera.hand().CamFromWorld(0.9 * i + 0.1);
    EXPECT_EQ(nearest.Draw(virtual_camera, pose, drawn), nearest.Nearest(pose));
    EXPECT_EQ(nearest.Nearest(scene.views[static_cast<std::size_t>(i)].cam_from_world), i);
    const Rendering expected = reference->Render(virtual_camera, pose);
    const cv::Mat inner(drawn, cv::Rect(20, 15, 120, 90)),
        inner_expected(Srgb8FromLinear(expected.linear), cv::Rect(20, 15, 120, 90));
    EXPECT_GT(CompareImages(inner, inner_expected, cv::Mat(inner.size(), CV_8U, cv::Scalar(255))).psnr_db,
              28);
  }

  // As the marker lies at first the light field is seen from its middle; turned with the marker, nearer with
  // it.
  MarkerMouse mouse(scene, Eigen::Vector3d::Zero());
  const Rigid3 first{Eigen::Quaterniond::Identity(), {0, 0, 0.5}};
  const Rigid3 start = mouse.CamFromWorld(first);
  double distance = 0;
  for (const SceneView& view : scene.views)
    distance += 0.2 * (view.center_in_world - scene.subject.center_in_world).norm();
  EXPECT_NEAR((start.OriginInSource() - scene.subject.center_in_world).norm(), distance, 0.02 * distance);
  EXPECT_LT((start * scene.subject.center_in_world).head<2>().norm(), 1e-9);
  EXPECT_GT(start.DirectionInSource(-Eigen::Vector3d::UnitY()).z(), 0.5) << "upright";
  const Rigid3 nearer = mouse.CamFromWorld({Eigen::Quaterniond::Identity(), {0, 0, 0.25}});
  EXPECT_NEAR((nearer * scene.subject.center_in_world).z(), 0.5 * (start * scene.subject.center_in_world).z(),
              1e-9);
  // Held off the middle it is seen from the side a little, and still in the middle of the picture.
  const Rigid3 aside = mouse.CamFromWorld({Eigen::Quaterniond::Identity(), {0.1, 0.05, 0.5}});
  EXPECT_LT((aside * scene.subject.center_in_world).head<2>().norm(), 1e-9);
  EXPECT_GT((aside.OriginInSource() - start.OriginInSource()).norm(), 0.15 * distance);
  const double turn = 0.2;
  const Rigid3 turned = mouse.CamFromWorld(
      {Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY())), {0, 0, 0.5}});
  const Eigen::Vector3d before = (start.OriginInSource() - scene.subject.center_in_world).normalized(),
                        after = (turned.OriginInSource() - scene.subject.center_in_world).normalized();
  EXPECT_NEAR(std::acos(before.dot(after)), turn, 1e-6);
}

// A robot's controller on this computer: its poses, the light field's unit is the metre.
TEST(PoseSourceCapture, ARobotSendsThePoses) {
  test::ScratchFolder scratch;
  const int probe = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  socklen_t size = sizeof address;
  getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
  close(probe);
  const std::string device = "sim:studio?width=160&height=120&look_away=0";
  const SimulatedCamera camera(SimulationOptions::FromUri(DeviceUri::Parse(device)));
  std::atomic<bool> over = false;
  std::thread robot([&] {
    int fd = -1;
    while (!over) {
      fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) break;
      close(fd);
      fd = -1;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    for (int i = 0; i < 600 && !over; ++i) {
      const Rigid3 pose = camera.hand().CamFromWorld(i / 100.0).Inverse();
      const std::string line = fmt::format("{} {} {} {} {} {} {} {}\n", i / 100.0, pose.translation.x(),
                                           pose.translation.y(), pose.translation.z(), pose.rotation.x(),
                                           pose.rotation.y(), pose.rotation.z(), pose.rotation.w());
      if (send(fd, line.data(), line.size(), MSG_NOSIGNAL) < 0) break;
    }
    while (!over) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (fd >= 0) close(fd);
  });
  const auto captured = RunUlf(
      fmt::format("capture --no-geometry '{}' -o {} --headless --quality fast --frames 60 --json --poses "
                  "'tcp:{}?clock=device&connect_s=60&wait_s=20' --subject 0,0,0.07,0.162",
                  device, (scratch / "field").string(), ntohs(address.sin_port)));
  over = true;
  robot.join();
  ASSERT_EQ(captured.exit_code, 0) << captured.errors;
  EXPECT_THAT(captured.errors, HasSubstr("listening for poses on 127.0.0.1"));
  const LightField light_field = ReadLightField(scratch / "field");
  EXPECT_EQ(light_field.units, "metres");
  ASSERT_GE(light_field.views.size(), 3u);
  for (const View& view : light_field.views)
    EXPECT_LT((view.CenterInWorld() - camera.hand().CamFromWorld(view.device_time_s).OriginInSource()).norm(),
              5e-4);
}

}  // namespace
}  // namespace ulf::pose_source_capture_test
