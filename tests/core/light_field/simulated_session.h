// A session of the simulator on disk: views along the hand's way with their true poses, and points of the
// scene where the views show them.
#pragma once

#include <filesystem>
#include <random>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/device_uri.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"

namespace ulf::test {

struct SessionOptions {
  int views = 40;
  double seconds = 60;  // between the first and the last
  int points = 400;
  double off_px = 0.3;  // standard deviation of where views show a point
  std::optional<ColorProfile> color_profile = {};
};

// `uri`: of `sim:`.
inline LightField WriteSimulatedSession(const std::filesystem::path& dir, const std::string& uri,
                                        const SessionOptions& options = {}) {
  const acquisition::SimulatedCamera camera(acquisition::SimulationOptions::FromUri(DeviceUri::Parse(uri)));
  CaptureHeader header;
  header.camera = camera.camera();
  header.color_profile = options.color_profile;
  LightField light_field;
  {
    auto writer = LightFieldWriter::Create(dir, header);
    for (int i = 0; i < options.views; ++i) {
      const auto frame_number =
          static_cast<std::uint64_t>(options.seconds * camera.options().fps * i / options.views);
      const Frame frame = camera.Capture(frame_number);
      View view;
      view.cam_from_world = *frame.known_cam_from_world;
      view.exposure_s = frame.exposure_s;
      view.gain = frame.gain;
      view.device_time_s = frame.device_time_s;
      writer.AddView(frame, view);
    }
    writer.SetSubject(camera.scene().subject());
    writer.Close(options.seconds);
    light_field = ReadLightField(dir);
  }
  std::mt19937 random(static_cast<unsigned>(camera.options().seed));
  std::normal_distribution<double> off(0, options.off_px);
  std::uniform_int_distribution<std::size_t> any_view(0, light_field.views.size() - 1);
  std::uniform_real_distribution<double> share(0.05, 0.95);
  for (int i = 0; i < options.points; ++i) {
    const View& from = light_field.views[any_view(random)];
    const Eigen::Vector2d img(share(random) * header.camera.width, share(random) * header.camera.height);
    const auto ray = header.camera.RayFromImg(img);
    if (!ray) continue;
    const Rigid3 world_from_cam = from.cam_from_world.Inverse();
    const Eigen::Vector3d direction = (world_from_cam.rotation * *ray).normalized();
    ScenePoint point;
    point.position_in_world = world_from_cam.translation +
                              camera.scene().DepthAlong(world_from_cam.translation, direction) * direction;
    for (const View& view : light_field.views) {
      const auto seen = header.camera.ImgFromCam(view.cam_from_world * point.position_in_world);
      if (!seen || !header.camera.Contains(*seen)) continue;
      const Eigen::Vector3d to_point = point.position_in_world - view.CenterInWorld();
      constexpr double kSame = 0.005;  // of the distance
      if (camera.scene().DepthAlong(view.CenterInWorld(), to_point.normalized()) <
          (1 - kSame) * to_point.norm())
        continue;
      point.track.push_back({view.id, *seen + Eigen::Vector2d(off(random), off(random))});
    }
    light_field.points.push_back(point);
  }
  return light_field;
}

}  // namespace ulf::test
