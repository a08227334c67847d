// Reads and writes calibration files: the intrinsics, in pixels, of the camera that the file identifies.
//
//   {"serial": "...", "maker": "...", "model": "...", "bus": "...", "source": "how it was obtained",
//    "modes": {"live": {"width": 640, "height": 480, "fx": ..., "fy": ..., "cx": ..., "cy": ...,
//                       "distortion": "radial-tangential|fisheye|none", "coefficients": [...],
//                       "pixel_centers": "half",
//                       "sensor": {"sensor_width": ..., "sensor_height": ..., "x": ..., "y": ...,
//                                  "width": ..., "height": ..., "binning_x": ..., "binning_y": ...},
//                       "sigma": [standard deviations of fx fy cx cy and the coefficients],
//                       "rms_px": ...,
//                       "flat_field": {...}, "color_profile": {...}}}}
//
// Everything except the modes' intrinsics may be missing. Mode "live" is for streamed frames, "still" for a
// tethered camera's photographs. "half": pixel centres are at integer + 0.5. "sensor" is a SensorWindow.
//
// ReadCalibrationFile() also reads, as mode "live", the files of other programs (lens_files/lens_files.h) and
// text files with one line `fx fy cx cy k1 k2 p1 p2 width height [fps]` and comments after '#'. That line has
// pixel centres at integers, as OpenCV has them, so 0.5 is added to cx and cy.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "core/geometry/camera_model.h"
#include "core/image/color_profile.h"
#include "core/image/flat_field.h"

namespace ulf::acquisition {

// The camera of a calibration. A webcam often has no serial number; model and bus path then identify it.
struct CameraIdentity {
  std::string serial = {}, maker = {}, model = {}, bus = {};
  static CameraIdentity Of(const DeviceInfo& info) { return {info.serial, info.maker, info.model, info.bus}; }
  bool operator==(const CameraIdentity&) const = default;
};

struct ModeCalibration {
  CameraModel camera = {};
  std::optional<SensorWindow> window = {};          // none: unknown
  std::optional<std::array<double, 9>> sigma = {};  // standard deviations of fx fy cx cy and the coefficients
  std::optional<double> rms_px = {};                // reprojection error
  std::optional<FlatField> flat_field = {};
  std::optional<ColorProfile> color_profile = {};
};

struct CalibrationFile {
  CameraIdentity identity = {};
  std::string source = {};
  std::map<std::string, ModeCalibration> modes = {};  // "live", "still"
  std::vector<std::string> warnings = {};  // for the user: what was assumed of another program's file
  bool is_ours = false;  // read from the format above, so that writing it again loses nothing
};

// `camera` selects one of several in another program's file by name or number (ReadLensText); empty: the file
// must contain only one. Throws Error that names the file and the missing or invalid key, and Refusal for a
// `camera` where the format has only one.
CalibrationFile ReadCalibrationFile(const std::filesystem::path& path, const std::string& camera = "");
void WriteCalibrationFile(const std::filesystem::path& path, const CalibrationFile& file);

// Returns one mode of a file; if there is none, throws Error that begins with `where` and lists the modes.
ModeCalibration ModeOf(const CalibrationFile& file, const std::string& mode, const std::string& where);

// Writes one mode into a new or existing file. Other modes of the file are kept; so are, where the new
// calibration has none, this mode's colour profile, and its flat field if it is for the same sensor window.
// Throws Error if the file belongs to another camera. A file that names no camera is replaced.
void UpdateCalibration(const std::filesystem::path& path, const CameraIdentity& identity,
                       const std::string& source, const std::string& mode,
                       const ModeCalibration& calibration);

// Read the intrinsics of one mode, with warnings to the log, and write them as UpdateCalibration() does.
CameraModel ReadCalibration(const std::filesystem::path& path, const std::string& mode = "live");
void WriteCalibration(const std::filesystem::path& path, const CameraModel& camera, const std::string& serial,
                      const std::string& source, const std::string& mode = "live");

}  // namespace ulf::acquisition
