// A light field with several cameras, masks and points that views show exactly where they project.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf::test {

inline CameraModel Straight() { return CameraModel::Pinhole(96, 64, 90); }
// Its principal point off the middle.
inline CameraModel Lens() {
  return {96, 72, 88, 89, 46.3, 37.8, Distortion::kRadialTangential, {-0.21, 0.06, 0.0008, -0.0011, 0}};
}
inline CameraModel SixthOrder() {
  CameraModel lens = Lens();
  lens.coefficients[4] = -0.01;
  return lens;
}
inline CameraModel Fisheye() {
  return {100, 80, 40, 40.5, 51.2, 39.1, Distortion::kFisheye, {0.02, -0.004, 0.001, -0.0002, 0}};
}

// In rows about (0, 0, 3), the views taking turns with the cameras.
inline LightField TrackedLightField(const std::filesystem::path& dir, const std::vector<CameraModel>& cameras,
                                    int views = 8, bool masks = false) {
  LightField light_field;
  light_field.root = dir;
  light_field.cameras = cameras;
  light_field.subject = Subject{{0, 0, 3}, 0.5};
  MakeFolder(dir / "images");
  cv::RNG random(3);
  for (int i = 0; i < views; ++i) {
    View& view = light_field.views.emplace_back();
    view.id = 2 * i + 3;  // some were taken back
    view.camera = i % static_cast<int>(cameras.size());
    view.image_path = fmt::format("images/{:06}.png", view.id);
    view.cam_from_world =
        LookAt({0.3 * i - 0.25 * views / 2, 0.1 * (i % 3), 0.02 * i}, {0, 0, 3}, {0, -1, 0});
    const CameraModel& camera = light_field.CameraOf(view);
    cv::Mat pixels(camera.height, camera.width, CV_8UC3);
    random.fill(pixels, cv::RNG::UNIFORM, 60, 256);  // nowhere black
    cv::imwrite((dir / view.image_path).string(), pixels);
    if (!masks || i % 2 == 0) continue;
    view.mask_path = fmt::format("masks/{:06}.png", view.id);
    MakeFolder(dir / "masks");
    cv::Mat mask(camera.height, camera.width, CV_8U, cv::Scalar(255));
    mask(cv::Rect(0, 0, camera.width / 2, camera.height)) = 0;
    cv::imwrite((dir / view.mask_path).string(), mask);
  }
  for (int i = 0; i < 60; ++i) {
    ScenePoint point;
    point.position_in_world = {random.uniform(-0.8, 0.8), random.uniform(-0.6, 0.6),
                               random.uniform(2.5, 3.6)};
    point.rgb = {static_cast<std::uint8_t>(4 * i), 7, 9};
    for (const View& view : light_field.views) {
      const CameraModel& camera = light_field.CameraOf(view);
      const auto img = camera.ImgFromCam(view.cam_from_world * point.position_in_world);
      if (img && camera.Contains(*img)) point.track.push_back({view.id, *img});
    }
    light_field.points.push_back(std::move(point));
  }
  MeasurePoints(light_field);
  WriteLightField(light_field);
  return light_field;
}

}  // namespace ulf::test
