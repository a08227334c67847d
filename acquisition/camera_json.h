// A camera model and the part of the sensor that it is of as JSON, the same in the journal, in calibration
// files and in recordings.
#pragma once

#include <nlohmann/json.hpp>

#include "acquisition/calibration/sensor_window.h"
#include "acquisition/camera_model.h"
#include "acquisition/json_fields.h"

namespace ulf {

// {"width","height","fx","fy","cx","cy","distortion":"none|radial-tangential|fisheye","coefficients":[5],
//  "pixel_centers":"half"}
nlohmann::json CameraToJson(const CameraModel& camera);
CameraModel CameraFromJson(const JsonPlace& place);

nlohmann::json WindowToJson(const SensorWindow& window);
SensorWindow WindowFromJson(const JsonPlace& place);

}  // namespace ulf
