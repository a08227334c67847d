// Converts camera models, sensor windows and vectors to JSON and back, the same in the journal, in
// calibration files, in recordings and in camera paths.
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/json_fields.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/sensor_window.h"

namespace ulf {

// {"width","height","fx","fy","cx","cy","distortion":"none|radial-tangential|fisheye","coefficients":[5],
//  "pixel_centers":"half"}
nlohmann::json CameraToJson(const CameraModel& camera);
// Also reads "pixel_centers":"integer" and then adds half a pixel to the principal point. Throws Error.
CameraModel CameraFromJson(const JsonPlace& place);

nlohmann::json Vector3ToJson(const Eigen::Vector3d& vector);  // [x, y, z]
Eigen::Vector3d Vector3FromJson(const JsonPlace& place, const char* key);

nlohmann::json WindowToJson(const SensorWindow& window);
SensorWindow WindowFromJson(const JsonPlace& place);

}  // namespace ulf
