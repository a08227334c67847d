#include "tests/tracking/scenes/rolling_light_field.h"

#include <fmt/core.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/atomic_file.h"
#include "core/geometry/trajectory.h"
#include "core/image/files/png_picture.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/points/point_tracks.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using tracking::Twist;

constexpr int kViews = 8;
constexpr double kFramesPerSecond = 30;  // of TexturedRoom's times

Twist TwistOf(int view, double turn_rad_s, double shift_m_s) {
  const double angle = 0.8 * view, across = std::cos(angle), down = std::sin(angle);
  Twist twist;
  twist << turn_rad_s * across, turn_rad_s * down, 0.2 * turn_rad_s, shift_m_s * down, shift_m_s * across,
      0.3 * shift_m_s;
  return twist;
}

// The row where the camera saw the point gives the time at which it did.
std::optional<Vector2d> SeenWhileMoving(const CameraModel& camera, const Rigid3& middle_row,
                                        const Twist& twist, double readout_s, const Vector3d& point) {
  auto seen = camera.ImgFromCam(middle_row * point);
  for (int i = 0; i < 10 && seen; ++i) {
    const double time_s = readout_s * (seen->y() / camera.height - 0.5);
    seen = camera.ImgFromCam(tracking::Perturbed(middle_row, time_s * twist) * point);
  }
  return seen;
}

void AddPoints(RollingLightField& rolling, double readout_s) {
  cv::RNG random(7);
  LightField& light_field = rolling.light_field;
  for (int i = 0; i < 300; ++i) {
    ScenePoint point;
    point.position_in_world = {random.uniform(-1.9, 1.9), random.uniform(-1.4, 1.4), kWallDistance};
    for (std::size_t v = 0; v < light_field.views.size(); ++v) {
      const CameraModel& camera = light_field.cameras[0];
      const auto seen = SeenWhileMoving(camera, rolling.middle_rows[v], rolling.twists[v], readout_s,
                                        point.position_in_world);
      if (seen && camera.Contains(*seen)) point.track.push_back({light_field.views[v].id, *seen});
    }
    if (point.track.size() >= 2) light_field.points.push_back(std::move(point));
  }
}

// As the tracker and `ulf refine` do.
void GivePicturesPoses(RollingLightField& rolling) {
  constexpr tracking::RefinePoseOptions kAllAlike{.huber_sigmas = 1e3, .gate_sigmas = 1e3, .rounds = 1};
  for (View& view : rolling.light_field.views) {
    std::vector<tracking::PointObservation> seen;
    for (const ScenePoint& point : rolling.light_field.points)
      for (const ViewObservation& observation : point.track)
        if (observation.view_id == view.id) seen.push_back({point.position_in_world, observation.in_img, 1});
    view.cam_from_world =
        tracking::RefinePose(rolling.light_field.CameraOf(view), seen, view.cam_from_world, kAllAlike)
            ->cam_from_world;
  }
}

void WritePictures(const RollingLightField& rolling, double readout_s) {
  const TexturedRoom wall = PlainWall();
  const LightField& light_field = rolling.light_field;
  MakeFolder(light_field.root / "images");
  for (std::size_t v = 0; v < light_field.views.size(); ++v) {
    const auto motion = [&](double frame) {
      return tracking::Perturbed(rolling.middle_rows[v], frame / kFramesPerSecond * rolling.twists[v]);
    };
    const CameraModel& camera = light_field.cameras[0];
    const cv::Mat picture = wall.TakeRolling(motion, 0, readout_s, camera, camera.height / 2).image.pixels;
    WriteFileAtomically(light_field.root / light_field.views[v].image_path, PngBytes(picture));
  }
}

}  // namespace

RollingLightField MakeRollingLightField(const CameraModel& camera, double readout_s, double turn_rad_s,
                                        double shift_m_s, const std::filesystem::path& folder) {
  RollingLightField rolling;
  LightField& light_field = rolling.light_field;
  light_field.root = folder;
  light_field.cameras = {camera};
  light_field.units = "metres";
  light_field.subject = Subject{{0, 0, kWallDistance}, 0.5};
  light_field.readout = ShutterReadout{readout_s, {}};
  for (int v = 0; v < kViews; ++v) {
    rolling.middle_rows.push_back(
        LookAt({0.25 * (v % 4) - 0.4, 0.3 * (v / 4) - 0.2, 0.05 * v}, {0, 0, kWallDistance}, {0, -1, 0}));
    rolling.twists.push_back(TwistOf(v, turn_rad_s, shift_m_s));
    View& view = light_field.views.emplace_back();
    view.id = v + 1;
    view.image_path = fmt::format("images/{:06}.png", view.id);
    view.cam_from_world = rolling.middle_rows.back();
    Eigen::Map<Twist>(view.twist.emplace().data()) = rolling.twists.back();
  }
  AddPoints(rolling, readout_s);
  GivePicturesPoses(rolling);
  if (folder.empty()) return rolling;
  WritePictures(rolling, readout_s);
  MeasurePoints(light_field);
  WriteLightField(light_field);
  return rolling;
}

TexturedRoom PlainWall() { return TexturedRoom({.furniture = Furniture::kWall, .seed = 5, .noise = 0}); }

cv::Mat DepthOfWall(const CameraModel& camera, const Rigid3& cam_from_world) {
  cv::Mat depth(camera.height, camera.width, CV_32F);
  const Vector3d normal = cam_from_world.rotation * Vector3d::UnitZ();
  const double offset = normal.dot(cam_from_world * Vector3d(0, 0, kWallDistance));
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const Vector3d ray = *camera.RayFromImg({x + 0.5, y + 0.5});
      depth.at<float>(y, x) = static_cast<float>(offset / normal.dot(ray) * ray.z());
    }
  return depth;
}

}  // namespace ulf::test
