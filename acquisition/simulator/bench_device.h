// Makes a device of a simulated calibration scene (a board, a card, a chart): it gives one picture for each
// call of Next(), without waiting, until the scene is over.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "acquisition/device/device.h"
#include "core/image/image.h"

namespace ulf::acquisition {

// What the device shows and reports. Both functions must depend on their arguments alone.
struct Bench {
  DeviceUri uri;
  std::uint64_t seed = 7;
  std::optional<CameraModel> camera = {};  // none: the device does not know it
  SensorWindow window = {};
  HeldAutomatics held = {};
  double fps = 15;  // picture `frame` has the time frame / fps, seconds
  std::function<Image(std::uint64_t frame, double time_s)> picture;
  std::function<bool(std::uint64_t frames)> is_over;  // whether the scene is over after so many frames
};
std::unique_ptr<Device> MakeBenchDevice(Bench bench);

}  // namespace ulf::acquisition
