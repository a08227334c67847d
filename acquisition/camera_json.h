// A camera model as JSON, the same in the journal and in calibration files.
#pragma once

#include <nlohmann/json.hpp>

#include "acquisition/camera_model.h"
#include "acquisition/json_fields.h"

namespace ulf {

// {"width","height","fx","fy","cx","cy","distortion":"none|radial-tangential|fisheye","coefficients":[5],
//  "pixel_centers":"half"}
nlohmann::json CameraToJson(const CameraModel& camera);
CameraModel CameraFromJson(const JsonPlace& place);

}  // namespace ulf
