// Which intrinsics a device's frames are used with. The first of:
//   1. the calibration file that the command names;
//   2. the one stored for the device's serial in the user's configuration folder,
//      $XDG_CONFIG_HOME (else ~/.config)/ulf/calibrations/SERIAL.json;
//   3. what the device itself knows (the simulator, a replayed light field);
//   4. a focal length in pixels, with the principal point in the middle and no distortion;
// else an Error that says how to calibrate.
//
// A calibration of another size is scaled when it has the same shape (within half a percent), as a sensor
// that bins or a video that was scaled; otherwise the picture was cropped, nobody knows where, and it is an
// Error.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "acquisition/camera_model.h"
#include "acquisition/device.h"

namespace ulf {

struct IntrinsicsArgs {
  std::string calibration_path;    // empty: not named
  std::optional<double> focal_px;  // of the frames as they come
};

// `width` and `height` are the frames'. `source` gets words for the record: "file F", "stored for serial S",
// "the device", "focal length given".
CameraModel ResolveIntrinsics(const Device& device, const IntrinsicsArgs& args, int width, int height,
                              std::string* source = nullptr);

// Where a calibration for this serial is stored.
std::filesystem::path StoredCalibrationPath(const std::string& serial);

}  // namespace ulf
