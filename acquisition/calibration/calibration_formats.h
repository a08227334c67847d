// Reads and writes intrinsics in the files of other programs.
//
//   kalibr  camchain YAML: camera_model pinhole with radtan, equidistant or none
//   ros     camera_info YAML: plumb_bob, equidistant, rational_polynomial without its denominator
//   opencv  FileStorage YAML, XML: camera_matrix and distortion_coefficients as OpenCV's own calibration
//           program writes them, fisheye_model 1 for the fisheye
//   colmap  cameras.txt: (SIMPLE_)PINHOLE, (SIMPLE_)RADIAL, OPENCV, FULL_OPENCV without its denominator,
//           (SIMPLE_RADIAL_, RADIAL_, OPENCV_)FISHEYE
//
// Kalibr, ROS and OpenCV have pixel centres at integers: their principal point is half a pixel less than
// ulf's in each axis. COLMAP has the same convention as ulf. A lens model that the format or ulf does not
// support (omni, double sphere, field-of-view, rational, thin prism, ...) is an Error that names it.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/camera_model.h"

namespace ulf::acquisition {

enum class CalibrationFormat { kKalibr, kRos, kOpenCv, kColmap };
const char* Name(CalibrationFormat format);
std::optional<CalibrationFormat> CalibrationFormatByName(const std::string& name);

// The format of a file's content; none: unknown.
std::optional<CalibrationFormat> DetectCalibrationFormat(const std::string& text);

// `camera` selects one of several by name or number ("cam1", "2"); empty: the file must contain only one.
// Errors name `where`.
CameraModel ReadCalibrationText(CalibrationFormat format, const std::string& text, const std::string& where,
                                const std::string& camera = "");

// `xml`: OpenCV's XML instead of its YAML.
std::string CalibrationText(CalibrationFormat format, const CameraModel& camera, const std::string& name,
                            bool xml = false);

}  // namespace ulf::acquisition
