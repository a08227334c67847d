// Makes a device of a simulated calibration scene: it gives numbered pictures, one for each call of Next(),
// until the scene is over.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "acquisition/device/device.h"
#include "core/image/image.h"

namespace ulf::acquisition {

struct Bench {
  DeviceUri uri;
  std::uint64_t seed = 7;
  std::optional<CameraModel> camera = {};  // none: the device does not know it
  SensorWindow window = {};
  HeldAutomatics held = {};
  double fps = 15;
  std::function<Image(std::uint64_t frame, double time_s)> picture;
  std::function<bool(std::uint64_t frames)> is_over;  // after so many
};
std::unique_ptr<Device> MakeBenchDevice(Bench bench);

}  // namespace ulf::acquisition
