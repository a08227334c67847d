// The part of a sensor that images show, and the conversion of intrinsics from one part to another.
//
// With pixel centres at integer + 0.5 the image's corner is the window's corner on the sensor, and binning
// divides lengths: sensor = window + binning * image, exactly. Distortion coefficients do not change.
#pragma once

#include <string>

#include "core/geometry/camera_model.h"

namespace ulf {

// Says which part of the sensor a device's images show. Lengths are unbinned sensor pixels.
struct SensorWindow {
  int sensor_width = 0, sensor_height = 0;
  int x = 0, y = 0, width = 0, height = 0;
  int binning_x = 1, binning_y = 1;  // also decimation
  bool operator==(const SensorWindow&) const = default;
};

// Converts `camera`, calibrated with the window `calibrated`, for images of `used`. Throws Error if the
// windows are of different sensors or contradict the camera's size.
CameraModel ForWindow(const CameraModel& camera, const SensorWindow& calibrated, const SensorWindow& used);

// Returns "640x480 at 0,0 of 1280x960, binning 2x2".
std::string Describe(const SensorWindow& window);

}  // namespace ulf
