// How much better a photograph of a rolling shutter shows what is there when it is drawn as of one instant,
// against the readout, with the depth of the scene, of tracked points, and of a plane.
#include <fmt/format.h>

#include <memory>
#include <opencv2/core.hpp>

#include "acquisition/simulator/simulated_camera.h"
#include "core/image/undistortion.h"
#include "render/quality/quality.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/refine/view_rows.h"

namespace ulf::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kShutterPoints = 300, kBorderPx = 24;
constexpr char kShutterPanel[] = "photograph against what is to be seen";

SimulatedCamera HandWithReadout(double readout_ms, unsigned seed) {
  return SimulatedCamera(SimulationOptions::FromUri(DeviceUri::Parse(
      fmt::format("sim:studio?noise=0&look_away=0&exposure_us=500&width=480&height=360&speed_deg_s=20&"
                  "readout_ms={}&seed={}",
                  readout_ms, seed))));
}

double DepthAlongAxis(const SimulatedCamera& camera, const Rigid3& cam_from_world, const Vector3d& ray) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const Vector3d direction = (world_from_cam.rotation * ray).normalized();
  return camera.scene().DepthAlong(world_from_cam.translation, direction) * ray.normalized().z();
}

// Where the moving camera sees a point of the scene: the row gives the time, at which it gives the row.
std::optional<Vector2d> SeenByRows(const SimulatedCamera& camera, double middle_s, const Vector3d& point) {
  auto seen = camera.camera().ImgFromCam(camera.hand().CamFromWorld(middle_s) * point);
  for (int i = 0; i < 10 && seen; ++i) {
    const double time_s = middle_s + RowTime(camera.options().readout_s, seen->y(), camera.camera().height);
    seen = camera.camera().ImgFromCam(camera.hand().CamFromWorld(time_s) * point);
  }
  return seen && camera.camera().Contains(*seen) ? seen : std::nullopt;
}

// The view as a capture leaves it: with exact points, the picture's pose and the velocity.
LightField ViewOf(const SimulatedCamera& camera, double middle_s) {
  const double readout_s = camera.options().readout_s;
  LightField light_field;
  light_field.cameras = {camera.camera()};
  light_field.readout = ShutterReadout{readout_s, {}};
  View& view = light_field.views.emplace_back();
  view.id = 1;
  view.cam_from_world = camera.hand().CamFromWorld(middle_s);
  Eigen::Map<Twist>(view.twist.emplace().data()) =
      TwistBetween(camera.hand().CamFromWorld(middle_s - readout_s / 2),
                   camera.hand().CamFromWorld(middle_s + readout_s / 2), readout_s);
  cv::RNG random(17);
  std::vector<PointObservation> seen;
  while (static_cast<int>(seen.size()) < kShutterPoints) {
    const auto ray = camera.camera().RayFromImg({random.uniform(0.0, 1.0) * camera.camera().width,
                                                 random.uniform(0.0, 1.0) * camera.camera().height});
    if (!ray) continue;
    const double depth = DepthAlongAxis(camera, view.cam_from_world, *ray);
    ScenePoint point;
    point.position_in_world = view.cam_from_world.Inverse() * (depth / ray->z() * *ray);
    const auto at = SeenByRows(camera, middle_s, point.position_in_world);
    if (!at) continue;
    point.track = {{view.id, *at}};
    seen.push_back({point.position_in_world, *at, 1});
    light_field.points.push_back(point);
  }
  constexpr RefinePoseOptions kAllAlike{.huber_sigmas = 1e3, .gate_sigmas = 1e3, .rounds = 1};
  view.cam_from_world = RefinePose(camera.camera(), seen, view.cam_from_world, kAllAlike)->cam_from_world;
  return light_field;
}

cv::Mat TrueDepth(const SimulatedCamera& camera, const Rigid3& cam_from_world) {
  const CameraModel& lens = camera.camera();
  cv::Mat depth(lens.height, lens.width, CV_32F, cv::Scalar(0));
  for (int y = 0; y < lens.height; ++y)
    for (int x = 0; x < lens.width; ++x)
      if (const auto ray = lens.RayFromImg({x + 0.5, y + 0.5}))
        depth.at<float>(y, x) = static_cast<float>(DepthAlongAxis(camera, cam_from_world, *ray));
  return depth;
}

double DbInside(const cv::Mat& picture, const cv::Mat& truth) {
  const cv::Rect inside(kBorderPx, kBorderPx, truth.cols - 2 * kBorderPx, truth.rows - 2 * kBorderPx);
  return cv::PSNR(picture(inside), truth(inside));
}

void AddView(double readout_ms, unsigned seed, double middle_s, Table& table) {
  const SimulatedCamera camera = HandWithReadout(readout_ms, seed);
  const LightField light_field = ViewOf(camera, middle_s);
  const CameraModel& lens = camera.camera();
  const Shot shot{.open_s = middle_s - 0.5e-3 * readout_ms - 0.00025, .exposure_s = 0.0005, .id = 1};
  const cv::Mat taken = Srgb8(camera.Capture(shot).image);
  const std::map<int, ViewRows> all_rows = RowsOfViews(light_field);
  const ViewRows& rows = all_rows.at(1);
  const cv::Mat truth = camera.CleanSrgb(rows.middle_from_world);
  const auto add = [&](const char* series, const cv::Mat& picture, const cv::Mat& expected, bool is_default) {
    table.Add(kShutterPanel, series, fmt::format("{:g} ms", readout_ms), readout_ms,
              DbInside(picture, expected), is_default);
  };
  const auto at_once = [&](const cv::Mat& depth) {
    return Undistorted(InstantMap(rows, lens, lens, depth), taken);
  };
  const double distance = (rows.middle_from_world * camera.scene().subject().center_in_world).z();
  add("as recorded, at the picture's pose", taken, camera.CleanSrgb(light_field.views[0].cam_from_world),
      false);
  add("one instant, depth of a plane",
      at_once(cv::Mat(lens.height, lens.width, CV_32F, cv::Scalar(distance))), truth, false);
  add("one instant, depths between 300 points", at_once(cv::Mat::zeros(lens.height, lens.width, CV_32F)),
      truth, false);
  add("one instant, depth of the scene", at_once(TrueDepth(camera, rows.middle_from_world)), truth, true);
}

Chart MeasureGlobalShutter(const Effort& effort) {
  Table table;
  table.Panel(kShutterPanel, {"readout [ms]"}, MoreIsBetter({"PSNR [dB]"}), {.compared = false});
  for (const double readout_ms : effort.Of(std::vector{10.0, 30.0}, {5.0, 10.0, 20.0, 30.0, 40.0}))
    for (const unsigned seed : effort.Seeds(3))
      for (int i = 0; i < effort.Of(1, 4); ++i) AddView(readout_ms, seed, 2.0 + 1.7 * i, table);
  return {.panels = table.panels()};
}

CHART(global_shutter, MeasureGlobalShutter, "Photographs of a rolling shutter drawn as of one instant",
      R"(Simulated studio, 480 x 360, without noise; a hand that moves at 20 degrees a second and trembles,
  exposure 0.5 ms. Each photograph against the scene as a global shutter sees it from the same place, without
  its outer 24 pixels; four views of each of three seeds. As recorded: against the scene from the picture's
  pose, which explains the bent picture best. One instant: as of `ulf export --global-shutter`, from the middle
  row's pose, which follows from 300 exact points and the mean velocity of the readout, with the depth that is
  named. Bars: lowest to highest. Ringed: what is done with a mesh.)");

}  // namespace
}  // namespace ulf::test
