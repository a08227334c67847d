// Which intrinsics a device's frames are used with. The first of:
//   1. the calibration file that the command names;
//   2. the one stored for this camera in the user's configuration folder,
//      $XDG_CONFIG_HOME (else ~/.config)/ulf/calibrations/SERIAL.json (for a camera without a serial,
//      MODEL_BUS.json);
//   3. what the device itself knows (the simulator);
//   4. a focal length in pixels, with the principal point in the middle and no distortion;
// else an Error that says how to calibrate. A recording that brings intrinsics itself has them before the
// stored ones: it was made with them, and is to give the same whatever is calibrated later.
//
// A calibration belongs to a camera: a file of another serial is an Error unless forced, also for what the
// camera recorded. Without a serial the model must be the same, and another bus path is a warning: nobody can
// tell two such cameras apart. A file that names no camera (one from another program) is taken with a warning
// that says how to bind it.
//
// Another part of the sensor or other binning than calibrated: recomputed exactly (sensor_window.h) where
// both are known. Where the device knows its part and the file does not, a file of the sensor's own size is
// of all of it, one of the images' size is taken for the same part with a warning, and any other is an Error.
// Where the device does not know, a calibration of another size is scaled when it has the same shape (within
// half a percent), as a video that was scaled; otherwise the picture was cropped, nobody knows where, and it
// is an Error. A calibration that names its part of the sensor brings a warning then.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/device/device.h"
#include "core/geometry/camera_model.h"

namespace ulf::acquisition {

struct IntrinsicsArgs {
  std::string calibration_path = {};    // empty: not named
  std::optional<double> focal_px = {};  // of the frames as they come
  bool force = false;                   // take a file of another camera all the same
};

// The source where there is nothing but --focal-px.
inline constexpr const char* kFocalLengthGiven = "focal length given";

struct ResolvedCalibration {
  CameraModel camera = {};
  std::optional<FlatField> flat_field = {};
  std::string source = {};  // for the record: "file F", "stored for serial S", "the device", ...
  std::vector<std::string> warnings = {};  // for the user
};

// `width` and `height` are the frames', 0 for those of the calibration; `mode` is "live" or "still".
ResolvedCalibration ResolveCalibration(const Device& device, const IntrinsicsArgs& args, int width,
                                       int height, const std::string& mode = "live");

// The same, intrinsics only; warnings go to the log.
CameraModel ResolveIntrinsics(const Device& device, const IntrinsicsArgs& args, int width, int height,
                              std::string* source = nullptr);

// Where a calibration for this serial, or this camera, is stored. Empty for one with neither serial nor
// model.
std::filesystem::path StoredCalibrationPath(const std::string& serial);
std::filesystem::path StoredCalibrationPath(const CameraIdentity& identity);

}  // namespace ulf::acquisition
