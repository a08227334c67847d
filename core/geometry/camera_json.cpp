#include "core/geometry/camera_json.h"

#include <algorithm>
#include <vector>

namespace ulf {
namespace {

constexpr std::array<std::string_view, 3> kDistortionNames{"none", "radial-tangential", "fisheye"};

}  // namespace

nlohmann::json CameraToJson(const CameraModel& camera) {
  const auto name = kDistortionNames[static_cast<std::size_t>(camera.distortion)];
  return {{"width", camera.width},  {"height", camera.height},
          {"fx", camera.fx},        {"fy", camera.fy},
          {"cx", camera.cx},        {"cy", camera.cy},
          {"distortion", name},     {"coefficients", camera.coefficients},
          {"pixel_centers", "half"}};
}

CameraModel CameraFromJson(const JsonPlace& place) {
  CameraModel camera;
  camera.width = place.Integer("width");
  camera.height = place.Integer("height");
  camera.fx = place.Number("fx");
  camera.fy = place.Number("fy");
  camera.cx = place.Number("cx");
  camera.cy = place.Number("cy");
  const std::string name = place.Text("distortion", "none");
  const auto known = std::ranges::find(kDistortionNames, name);
  if (known == kDistortionNames.end())
    throw Error("{}: unknown distortion '{}'; known are none, radial-tangential, fisheye", place.where, name);
  camera.distortion = static_cast<Distortion>(known - kDistortionNames.begin());
  if (place.Has("coefficients")) {
    const nlohmann::json& list = place.Raw("coefficients");
    const std::size_t count = std::min<std::size_t>(list.is_array() ? list.size() : 0, 5);
    const std::vector<double> values = place.Numbers("coefficients", count);
    std::ranges::copy(values, camera.coefficients.begin());
  }
  if (place.Text("pixel_centers", "half") == "integer") {
    camera.cx += 0.5;
    camera.cy += 0.5;
  }
  camera.Validate(place.where);
  return camera;
}

nlohmann::json Vector3ToJson(const Eigen::Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

Eigen::Vector3d Vector3FromJson(const JsonPlace& place, const char* key) {
  const std::vector<double> numbers = place.Numbers(key, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

nlohmann::json WindowToJson(const SensorWindow& window) {
  return {{"sensor_width", window.sensor_width},
          {"sensor_height", window.sensor_height},
          {"x", window.x},
          {"y", window.y},
          {"width", window.width},
          {"height", window.height},
          {"binning_x", window.binning_x},
          {"binning_y", window.binning_y}};
}

SensorWindow WindowFromJson(const JsonPlace& place) {
  return {place.Integer("sensor_width"),
          place.Integer("sensor_height"),
          place.Integer("x"),
          place.Integer("y"),
          place.Integer("width"),
          place.Integer("height"),
          place.Integer("binning_x", 1),
          place.Integer("binning_y", 1)};
}

}  // namespace ulf
