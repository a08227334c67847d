#include "core/geometry/sensor_window.h"

#include "core/base/error.h"

namespace ulf {

CameraModel ForWindow(const CameraModel& camera, const SensorWindow& calibrated, const SensorWindow& used) {
  if (calibrated.sensor_width != used.sensor_width || calibrated.sensor_height != used.sensor_height)
    throw Error("calibrated on a sensor of {}x{} pixels, this one has {}x{}: another camera; calibrate it",
                calibrated.sensor_width, calibrated.sensor_height, used.sensor_width, used.sensor_height);
  for (const SensorWindow& window : {calibrated, used})
    if (window.binning_x < 1 || window.binning_y < 1 || window.width < window.binning_x ||
        window.height < window.binning_y)
      throw Error("'{}' is no part of a sensor; correct the calibration file or the camera's settings",
                  Describe(window));
  if (calibrated.width / calibrated.binning_x != camera.width ||
      calibrated.height / calibrated.binning_y != camera.height)
    throw Error("the calibration is for {}x{} images, its window ({}) gives {}x{}; calibrate again",
                camera.width, camera.height, Describe(calibrated), calibrated.width / calibrated.binning_x,
                calibrated.height / calibrated.binning_y);
  CameraModel moved = camera;
  moved.width = used.width / used.binning_x;
  moved.height = used.height / used.binning_y;
  moved.fx = camera.fx * calibrated.binning_x / used.binning_x;
  moved.fy = camera.fy * calibrated.binning_y / used.binning_y;
  moved.cx = (calibrated.x + camera.cx * calibrated.binning_x - used.x) / used.binning_x;
  moved.cy = (calibrated.y + camera.cy * calibrated.binning_y - used.y) / used.binning_y;
  return moved;
}

std::string Describe(const SensorWindow& window) {
  return fmt::format("{}x{} at {},{} of {}x{}, binning {}x{}", window.width, window.height, window.x,
                     window.y, window.sensor_width, window.sensor_height, window.binning_x, window.binning_y);
}

}  // namespace ulf
