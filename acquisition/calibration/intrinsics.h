// Selects the intrinsics for a device's frames, the first of:
//   1. the calibration file that the command names;
//   2. the one stored for this camera in the user's configuration folder,
//      $XDG_CONFIG_HOME (else ~/.config)/ulf/calibrations/SERIAL.json (for a camera without a serial,
//      MODEL_BUS.json);
//   3. the intrinsics that the device itself knows (the simulator);
//   4. a focal length in pixels, with the principal point in the middle and no distortion;
//   5. where a command asks for it, a guessed focal length, with which the tracker begins to find the lens.
// Without any of them it throws an Error that tells how to calibrate. Intrinsics that a recording contains
// take precedence over the stored file, so that later calibrations do not change its result.
//
// A calibration belongs to a camera. A file for another serial number is an Error unless forced, for
// recordings of a camera too. Without a serial number the model must be the same, and another bus path is a
// warning, because two such cameras cannot be distinguished. A file that names no camera (from another
// program) is used with a warning that tells how to bind it.
//
// For another part of the sensor or another binning the intrinsics are recomputed exactly (sensor_window.h)
// if both parts are known. If only the device's part is known: a file of the sensor's size is assumed to
// cover the whole sensor, one of the image's size to cover the same part (with a warning), any other is an
// Error. If the device's part is unknown: a calibration of the same aspect ratio (within half a percent) is
// scaled, as for a scaled video, with a warning if it names its part of the sensor; with any other, the
// pictures were turned or were cropped at an unknown place, which is an Error.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/device/device.h"
#include "core/geometry/camera_model.h"

namespace ulf::acquisition {

struct IntrinsicsArgs {
  std::string calibration_path = {};            // empty: not named
  std::optional<double> focal_px = {};          // of the frames in their own size
  bool force = false;                           // accept a file of another camera
  std::optional<double> guessed_focal_px = {};  // GuessFocalPx(), to use if nothing else is known
};

// Guesses the focal length of a frame, in its pixels, by its Exif data, else for a lens of 61 degrees.
double GuessFocalPx(const Frame& frame);

// Values of ResolvedCalibration::source, as light fields record them: a focal length that was given or
// guessed, a lens that the tracker found in place of the given one, and one that refining found.
inline constexpr const char* kFocalLengthGiven = "focal length given";
inline constexpr const char* kFocalLengthGuessed = "focal length guessed";
inline constexpr const char* kLensFoundInCapture = "the images of the capture";
inline constexpr const char* kLensFoundByRefining = "the images, refined together";
// Whether a lens was measured, or only a focal length was given or guessed.
enum class LensOrigin { kMeasured, kGiven, kGuessed };
// Reads the origin from the source that a light field records for a camera.
LensOrigin OriginOfSource(std::string_view source);

struct ResolvedCalibration {
  CameraModel camera = {};
  std::optional<FlatField> flat_field = {};
  std::optional<ColorProfile> color_profile = {};
  LensOrigin origin = LensOrigin::kMeasured;
  std::string source = {};  // for the record: "file F", "stored for serial S", "the device", ...
  std::vector<std::string> warnings = {};  // for the user
};

// `width` and `height`: of the frames; 0: the calibration's own size. `mode`: "live" or "still".
ResolvedCalibration ResolveCalibration(const Device& device, const IntrinsicsArgs& args, int width,
                                       int height, const std::string& mode = "live");

// Resolves the intrinsics alone; warnings go to the log.
CameraModel ResolveIntrinsics(const Device& device, const IntrinsicsArgs& args, int width, int height,
                              std::string* source = nullptr, LensOrigin* origin = nullptr);

// Returns the path of the stored calibration of a serial number or camera; empty for a camera that is unknown
// or has neither serial number nor model.
std::filesystem::path StoredCalibrationPath(const std::string& serial);
std::filesystem::path StoredCalibrationPath(const CameraIdentity& identity);

}  // namespace ulf::acquisition
