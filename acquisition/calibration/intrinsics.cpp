#include "acquisition/calibration/intrinsics.h"

#include <cctype>
#include <cmath>
#include <cstdlib>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/error.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

fs::path ConfigurationFolder() {
  const char* configured = std::getenv("XDG_CONFIG_HOME");
  if (configured && *configured) return configured;
  const char* home = std::getenv("HOME");
  return home && *home ? fs::path(home) / ".config" : fs::path(".config");
}

CameraModel ForSize(const CameraModel& camera, int width, int height, const std::string& owner) {
  if (camera.width == width && camera.height == height) return camera;
  const double wide = static_cast<double>(width) / camera.width,
               high = static_cast<double>(height) / camera.height;
  constexpr double kSameShape = 0.005;
  if (std::abs(wide / high - 1) > kSameShape)
    throw Error(
        "{}: made for {}x{}, but the frames are {}x{}, another shape: cropped, and where is not known; "
        "calibrate at "
        "this size",
        owner, camera.width, camera.height, width, height);
  return camera.ScaledTo(width, height);
}

}  // namespace

fs::path StoredCalibrationPath(const std::string& serial) {
  std::string name;
  for (const char c : serial)
    name += std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' ? c : '_';
  return ConfigurationFolder() / "ulf" / "calibrations" / (name + ".json");
}

CameraModel ResolveIntrinsics(const Device& device, const IntrinsicsArgs& args, int width, int height,
                              std::string* source) {
  const DeviceInfo info = device.Info();
  const auto found = [&](const CameraModel& camera, const std::string& from) {
    const CameraModel sized = ForSize(camera, width, height, from);
    if (source) *source = from;
    return sized;
  };
  if (!args.calibration_path.empty())
    return found(ReadCalibration(args.calibration_path), "file " + args.calibration_path);
  if (!info.serial.empty()) {
    const fs::path stored = StoredCalibrationPath(info.serial);
    if (fs::exists(stored))
      return found(ReadCalibration(stored), "stored for serial " + info.serial + ", " + stored.string());
  }
  if (const auto own = device.Camera()) return found(*own, "the device " + info.uri);
  if (args.focal_px) {
    if (!(*args.focal_px > 0) || !std::isfinite(*args.focal_px))
      throw UsageError("--focal-px {}: the focal length must be positive", *args.focal_px);
    return found(CameraModel::Pinhole(width, height, *args.focal_px), "focal length given");
  }
  throw Error(
      "{}: the camera's intrinsics are not known. Give --calibration FILE; or store one for serial '{}' as "
      "{}; or "
      "give --focal-px F for a lens with little distortion (F = image width in pixels x focal length / "
      "sensor width)",
      info.uri, info.serial,
      info.serial.empty() ? "(it has none)" : StoredCalibrationPath(info.serial).string());
}

}  // namespace ulf
