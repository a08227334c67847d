// Converts camera models, sensor windows and vectors to JSON and back, the same in the journal, in
// calibration files, in recordings and in camera paths.
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/json_fields.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/sensor_window.h"

namespace ulf {

// Returns {"width","height","fx","fy","cx","cy","distortion":"none|radial-tangential|fisheye",
// "coefficients":[five numbers],"pixel_centers":"half"}.
nlohmann::json CameraToJson(const CameraModel& camera);
// Without distortion or coefficients in it, a camera has none. For "pixel_centers":"integer" adds half a
// pixel to the principal point. Throws Error, as the other readers do, if a number is missing or impossible.
CameraModel CameraFromJson(const JsonPlace& place);

nlohmann::json Vector3ToJson(const Eigen::Vector3d& vector);  // [x, y, z]
Eigen::Vector3d Vector3FromJson(const JsonPlace& place, const char* key);

nlohmann::json WindowToJson(const SensorWindow& window);
SensorWindow WindowFromJson(const JsonPlace& place);

}  // namespace ulf
