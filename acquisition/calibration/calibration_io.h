// Calibration files: a camera's intrinsics on disk, for every command's --calibration.
//
//   {"modes": {"live": {"width": 640, "height": 480, "fx": ..., "fy": ..., "cx": ..., "cy": ...,
//                       "distortion": "radial-tangential|fisheye|none", "coefficients": [...],
//                       "pixel_centers": "half"}},
//    "serial": "...", "source": "how it was obtained"}
//
// Read as well: a text file with one line of numbers, `fx fy cx cy k1 k2 p1 p2 width height [fps]`, comments
// behind
// '#', whose principal point counts from integer pixel centres as OpenCV does (0.5 is added on reading).
#pragma once

#include <filesystem>
#include <string>

#include "acquisition/camera_model.h"

namespace ulf {

// Throws Error naming the file, the mode and the key that is missing or wrong.
CameraModel ReadCalibration(const std::filesystem::path& path, const std::string& mode = "live");

// Writes one mode; other modes that the file already holds for the same serial are kept.
void WriteCalibration(const std::filesystem::path& path, const CameraModel& camera, const std::string& serial,
                      const std::string& source, const std::string& mode = "live");

}  // namespace ulf
