// Intrinsics in other programs' files.
//
//   kalibr  camchain YAML: camera_model pinhole with radtan, equidistant or none
//   ros     camera_info YAML: plumb_bob, equidistant, rational_polynomial without its denominator
//   opencv  FileStorage YAML, XML: camera_matrix and distortion_coefficients as OpenCV's own calibration
//           program writes them, fisheye_model 1 for the fisheye
//   colmap  cameras.txt: (SIMPLE_)PINHOLE, (SIMPLE_)RADIAL, OPENCV, FULL_OPENCV without its denominator,
//           (SIMPLE_RADIAL_, RADIAL_, OPENCV_)FISHEYE
//
// Kalibr, ROS and OpenCV count pixels from integer centres: their principal point is half a pixel less than
// ours in each axis. COLMAP's and ours are the same. What a format cannot say, and what cannot be said here
// (omni, double sphere, field-of-view, rational, thin prism, ...), is an Error that names the model.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/camera_model.h"

namespace ulf::acquisition {

enum class CalibrationFormat { kKalibr, kRos, kOpenCv, kColmap };
const char* Name(CalibrationFormat format);
std::optional<CalibrationFormat> CalibrationFormatByName(const std::string& name);

// By content; none: neither of these.
std::optional<CalibrationFormat> DetectCalibrationFormat(const std::string& text);

// `camera` picks one of several by name or number ("cam1", "2"); empty: there must be only one. `where` names
// the file in errors.
CameraModel ReadCalibrationText(CalibrationFormat format, const std::string& text, const std::string& where,
                                const std::string& camera = "");

// `xml`: OpenCV's XML instead of its YAML.
std::string CalibrationText(CalibrationFormat format, const CameraModel& camera, const std::string& name,
                            bool xml = false);

}  // namespace ulf::acquisition
