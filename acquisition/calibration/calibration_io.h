// Calibration files: a camera's intrinsics on disk, bound to the camera, for every command's --calibration.
//
//   {"serial": "...", "maker": "...", "model": "...", "bus": "...", "source": "how it was obtained",
//    "modes": {"live": {"width": 640, "height": 480, "fx": ..., "fy": ..., "cx": ..., "cy": ...,
//                       "distortion": "radial-tangential|fisheye|none", "coefficients": [...],
//                       "pixel_centers": "half",
//                       "sensor": {"sensor_width": ..., "sensor_height": ..., "x": ..., "y": ..., "width":
//                       ...,
//                                  "height": ..., "binning_x": ..., "binning_y": ...},
//                       "sigma": [fx fy cx cy and the coefficients'], "rms_px": ...,
//                       "flat_field": {...}}}}
//
// All but the modes' intrinsics may be missing. Read as well: Kalibr, ROS, OpenCV and COLMAP files
// (calibration_formats.h), and a text file with one line of numbers, `fx fy cx cy k1 k2 p1 p2 width height
// [fps]`, comments behind '#', whose principal point counts from integer pixel centres as OpenCV does (0.5 is
// added on reading).
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "acquisition/device/device.h"
#include "core/geometry/camera_model.h"
#include "core/image/flat_field.h"

namespace ulf::acquisition {

// Which camera a calibration is of. A webcam often has no serial; then model and bus path have to do.
struct CameraIdentity {
  std::string serial = {}, maker = {}, model = {}, bus = {};
  static CameraIdentity Of(const DeviceInfo& info) { return {info.serial, info.maker, info.model, info.bus}; }
  bool operator==(const CameraIdentity&) const = default;
};

struct ModeCalibration {
  CameraModel camera = {};
  std::optional<SensorWindow> window = {};          // none: the whole image is what there is
  std::optional<std::array<double, 9>> sigma = {};  // of fx fy cx cy and the coefficients
  std::optional<double> rms_px = {};
  std::optional<FlatField> flat_field = {};
};

struct CalibrationFile {
  CameraIdentity identity = {};
  std::string source = {};
  std::map<std::string, ModeCalibration> modes = {};  // "live", "still"
};

// Throws Error naming the file and the key that is missing or wrong.
CalibrationFile ReadCalibrationFile(const std::filesystem::path& path);
void WriteCalibrationFile(const std::filesystem::path& path, const CalibrationFile& file);

// One mode of a file, with what the file says about the camera. Throws Error that lists the modes there are.
ModeCalibration ModeOf(const CalibrationFile& file, const std::string& mode, const std::string& where);

// Writes one mode; other modes that the file already holds for the same camera are kept, and of the mode's
// own entry the flat field where the new one has none and is for the same window.
void UpdateCalibration(const std::filesystem::path& path, const CameraIdentity& identity,
                       const std::string& source, const std::string& mode,
                       const ModeCalibration& calibration);

// Intrinsics only.
CameraModel ReadCalibration(const std::filesystem::path& path, const std::string& mode = "live");
void WriteCalibration(const std::filesystem::path& path, const CameraModel& camera, const std::string& serial,
                      const std::string& source, const std::string& mode = "live");

}  // namespace ulf::acquisition
