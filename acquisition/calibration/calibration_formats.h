// Writes intrinsics as files of other programs; lens_files/ reads them.
//
//   kalibr  camchain YAML: camera_model pinhole with radtan or equidistant
//   ros     camera_info YAML: plumb_bob or equidistant
//   opencv  FileStorage YAML, XML: camera_matrix and distortion_coefficients as OpenCV's own calibration
//           program writes them, fisheye_model 1 for the fisheye
//   colmap  cameras.txt
//
// Kalibr, ROS and OpenCV have pixel centres at integers: their principal point is half a pixel less than
// ulf's in each axis. COLMAP has the same convention as ulf.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/camera_model.h"

namespace ulf::acquisition {

enum class CalibrationFormat { kKalibr, kRos, kOpenCv, kColmap };
const char* Name(CalibrationFormat format);
std::optional<CalibrationFormat> CalibrationFormatByName(const std::string& name);

// Returns the file's text. `name`: of the camera, in ROS's files; `xml`: OpenCV's XML instead of its YAML.
// Throws Error for a lens model that the format does not have.
std::string CalibrationText(CalibrationFormat format, const CameraModel& camera, const std::string& name,
                            bool xml = false);

}  // namespace ulf::acquisition
