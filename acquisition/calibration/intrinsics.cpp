#include "acquisition/calibration/intrinsics.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/geometry/sensor_window.h"
#include "core/image/files/exif.h"

namespace ulf::acquisition {
namespace {

namespace fs = std::filesystem;

fs::path ConfigurationFolder() {
  const char* configured = std::getenv("XDG_CONFIG_HOME");
  if (configured && *configured) return configured;
  const char* home = std::getenv("HOME");
  return home && *home ? fs::path(home) / ".config" : fs::path(".config");
}

constexpr double kSameShape = 0.005;  // relative difference of aspect ratios; guessed: rounding of sizes

// Returns whether the frames have the shape of the lens's pictures after a quarter turn.
bool IsTurned(const CameraModel& camera, int width, int height) {
  const double turned = static_cast<double>(width) / camera.height * camera.width / height;
  const bool is_square = std::abs(static_cast<double>(width) / height - 1) < kSameShape;
  return std::abs(turned - 1) < kSameShape && !is_square;
}

void RefuseTurned(const CameraModel& camera, int width, int height, const std::string& owner) {
  if (IsTurned(camera, width, height))
    throw Error(
        "{}: made for {}x{}, but the frames are {}x{}: width and height are exchanged, so the pictures of "
        "one of the two are turned by a quarter turn, and it is unknown to which side. Calibrate with "
        "pictures that are upright as these frames are (ulf calibrate), or turn the frames back",
        owner, camera.width, camera.height, width, height);
}

CameraModel ForSize(const CameraModel& camera, int width, int height, const std::string& owner) {
  if (camera.width == width && camera.height == height) return camera;
  const double wide = static_cast<double>(width) / camera.width,
               high = static_cast<double>(height) / camera.height;
  RefuseTurned(camera, width, height, owner);
  if (std::abs(wide / high - 1) > kSameShape)
    throw Error(
        "{}: made for {}x{}, but the frames are {}x{}, another shape: they were cropped at an unknown place; "
        "calibrate at this size",
        owner, camera.width, camera.height, width, height);
  return camera.ScaledTo(width, height);
}

// Throws Error where the calibration is of another camera; warns where that is unknown.
void RequireSameCamera(const CameraIdentity& calibrated, const CameraIdentity& used, const std::string& owner,
                       bool force, std::vector<std::string>& warnings) {
  const auto refuse = [&](const char* what, const std::string& theirs, const std::string& ours) {
    const std::string text =
        fmt::format("{}: calibrated with {} '{}', this camera has '{}'", owner, what, theirs, ours);
    if (!force)
      throw Error("{}; calibrate this camera (ulf calibrate), or accept the file ({})", text,
                  Parameter("force_calibration"));
    warnings.push_back(fmt::format("{}: used because of {}", text, Parameter("force_calibration")));
  };
  if (!calibrated.serial.empty() && !used.serial.empty()) {
    if (calibrated.serial != used.serial) refuse("serial", calibrated.serial, used.serial);
    return;
  }
  // The camera of a folder of images or a video is unknown.
  if (used.bus == "files") return;
  if (!calibrated.model.empty() && !used.model.empty() && calibrated.model != used.model)
    return refuse("model", calibrated.model, used.model);
  if (calibrated.serial.empty() && !used.serial.empty()) {
    warnings.push_back(fmt::format(
        "{}: not bound to any {}, so it is unknown whether it belongs to this one, serial '{}'. If it does, "
        "bind it: ulf calibration FILE --serial '{}' -o NEW_FILE",
        owner, calibrated.model.empty() ? "camera" : "single camera, only to the model", used.serial,
        used.serial));
    return;
  }
  if (calibrated.serial.empty() && !calibrated.model.empty() && calibrated.bus != used.bus)
    warnings.push_back(
        fmt::format("{}: the camera has no serial; it was at {} when calibrated and is now at {}: make sure "
                    "that it is the same one",
                    owner, calibrated.bus.empty() ? "an unknown place" : calibrated.bus,
                    used.bus.empty() ? "an unknown place" : used.bus));
}

// Returns the part of the sensor that a calibration without one is assumed to cover, for a device that
// reports its own: the whole sensor where it has that size; the part in use where it has that size, with a
// warning, because another part may have it too. Throws Error for any other size, which a region or binning
// may have caused.
SensorWindow AssumedWindow(const CameraModel& camera, const SensorWindow& used, const std::string& owner,
                           std::vector<std::string>& warnings) {
  if (camera.width == used.sensor_width && camera.height == used.sensor_height)
    return {used.sensor_width, used.sensor_height, 0, 0, used.sensor_width, used.sensor_height};
  RefuseTurned(camera, used.width / used.binning_x, used.height / used.binning_y, owner);
  const std::string how =
      fmt::format("ulf calibration FILE --sensor {}x{} --roi WIDTHxHEIGHT+X+Y --binning 1x1 -o NEW_FILE",
                  used.sensor_width, used.sensor_height);
  if (camera.width != used.width / used.binning_x || camera.height != used.height / used.binning_y)
    throw Error(
        "{}: made for {}x{}, but the camera is set to {}, and the calibration does not say which part of the "
        "sensor it covers: a region and binning would give different intrinsics. Add it ({}), or calibrate "
        "with the present settings",
        owner, camera.width, camera.height, Describe(used), how);
  warnings.push_back(fmt::format(
      "{}: does not say which part of the sensor it covers; ulf assumes the part in use ({}). If it "
      "was another of the same size, the principal point is wrong: add it ({})",
      owner, Describe(used), how));
  return used;
}

// Returns a mode's calibration for the device's window, else for the frames' size.
ResolvedCalibration Fit(const ModeCalibration& calibration, const std::optional<SensorWindow>& window,
                        int width, int height, const std::string& owner) {
  ResolvedCalibration resolved{.camera = calibration.camera,
                               .flat_field = calibration.flat_field,
                               .color_profile = calibration.color_profile,
                               .source = owner};
  const bool any_size = width == 0;
  if (window) {
    const SensorWindow from = calibration.window
                                  ? *calibration.window
                                  : AssumedWindow(calibration.camera, *window, owner, resolved.warnings);
    try {
      resolved.camera = ForWindow(calibration.camera, from, *window);
    } catch (const Error& error) {
      throw Error("{}: {}", owner, error.what());
    }
    if (resolved.flat_field) resolved.flat_field = resolved.flat_field->ForWindow(from, *window);
    if (!any_size && (resolved.camera.width != width || resolved.camera.height != height))
      throw Error(
          "{}: the frames are {}x{}, but the camera reports {}: neither region nor binning explains that; "
          "open the camera again",
          owner, width, height, Describe(*window));
    return resolved;
  }
  if (calibration.window && !any_size)
    resolved.warnings.push_back(
        fmt::format("{}: covers one part of the sensor ({}), but it is unknown which part these frames show; "
                    "ulf assumes the same. If it was another region, the principal point is wrong",
                    owner, Describe(*calibration.window)));
  if (!any_size && (resolved.camera.width != width || resolved.camera.height != height)) {
    resolved.camera = ForSize(resolved.camera, width, height, owner);
    if (resolved.flat_field) resolved.flat_field = resolved.flat_field->ForSize(width, height);
  }
  return resolved;
}

bool IsRecording(const DeviceInfo& info) { return info.uri.starts_with("replay:"); }

// Returns what the device itself knows of its frames, or of its photographs.
std::optional<ResolvedCalibration> OwnCalibration(const Device& device, int width, int height,
                                                  const std::string& mode) {
  const bool still = mode == "still";
  const auto camera = still ? device.StillCamera() : device.Camera();
  if (!camera) return std::nullopt;
  const std::string owner = "the device " + device.Info().uri;
  ResolvedCalibration own{.camera = width > 0 ? ForSize(*camera, width, height, owner) : *camera,
                          .source = owner};
  if (const auto flat_field = device.KnownFlatField(still ? FrameKind::kStill : FrameKind::kLive))
    own.flat_field =
        own.camera == *camera ? *flat_field : flat_field->ForSize(own.camera.width, own.camera.height);
  if (const auto profile = device.KnownColorProfile(still ? FrameKind::kStill : FrameKind::kLive))
    own.color_profile = *profile;
  return own;
}

std::string FileName(const std::string& text) {
  std::string name;
  for (const char c : text)
    name += std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' ? c : '_';
  return name + ".json";
}

// A lens is round, pixels need not be: `focal_px` is in widths of a pixel.
CameraModel PinholeOf(const DeviceInfo& info, int width, int height, double focal_px) {
  CameraModel camera = CameraModel::Pinhole(width, height, focal_px);
  camera.fy *= info.pixel_aspect;
  return camera;
}

ResolvedCalibration Resolve(const Device& device, const IntrinsicsArgs& args, int width, int height,
                            const std::string& mode) {
  const DeviceInfo info = device.Info();
  const CameraIdentity identity = CameraIdentity::Of(info);
  // The live frames' window does not apply to photographs of a tethered camera.
  const auto window = mode == "live" ? device.Window() : std::nullopt;
  const auto from_file = [&](const fs::path& path, const std::string& from) {
    const CalibrationFile file = ReadCalibrationFile(path);
    std::vector<std::string> warnings = file.warnings;
    RequireSameCamera(file.identity, identity, from, args.force, warnings);
    ResolvedCalibration resolved = Fit(ModeOf(file, mode, path.string()), window, width, height, from);
    resolved.warnings.insert(resolved.warnings.begin(), warnings.begin(), warnings.end());
    return resolved;
  };
  if (!args.calibration_path.empty())
    return from_file(args.calibration_path, "file " + args.calibration_path);
  const auto own = OwnCalibration(device, width, height, mode);
  if (own && IsRecording(info)) return *own;
  const fs::path stored = StoredCalibrationPath(identity);
  if (!stored.empty() && fs::exists(stored)) {
    const std::string camera = info.serial.empty() ? info.model + " at " + info.bus : "serial " + info.serial;
    // A file without this mode is not used where the device knows its own intrinsics.
    if (ReadCalibrationFile(stored).modes.count(mode) || !own)
      return from_file(stored, "stored for " + camera + ", " + stored.string());
  }
  if (own) return *own;
  if (args.focal_px) {
    if (!(*args.focal_px > 0) || !std::isfinite(*args.focal_px))
      throw Refusal(Parameter("focal_px"), fmt::format("{}", *args.focal_px),
                    "the focal length must be positive", "");
    // The range reaches from wider than any rectilinear lens to longer than any telescope on a small sensor.
    constexpr double kShortest = 0.1, kLongest = 50;
    const double longer_side = std::max(width, height);
    if (*args.focal_px < kShortest * longer_side || *args.focal_px > kLongest * longer_side)
      throw Refusal(Parameter("focal_px"), fmt::format("{:g}", *args.focal_px),
                    fmt::format("no lens has that with pictures of {}x{}", width, height),
                    "give the focal length in pixels of these pictures (width in pixels x focal length / "
                    "sensor width)");
    return {.camera = PinholeOf(info, width, height, *args.focal_px),
            .flat_field = {},
            .color_profile = {},
            .origin = LensOrigin::kGiven,
            .source = kFocalLengthGiven,
            .warnings = {}};
  }
  if (args.guessed_focal_px)
    return {
        .camera = PinholeOf(info, width, height, *args.guessed_focal_px),
        .flat_field = {},
        .color_profile = {},
        .origin = LensOrigin::kGuessed,
        .source = kFocalLengthGuessed,
        .warnings = {fmt::format("{}: the camera's intrinsics are not known; a focal length of {:.0f} px is "
                                 "guessed until the images show which it is",
                                 info.uri, *args.guessed_focal_px)}};
  const bool is_taken = IsTaken(device.Source());
  throw Error(
      "{}: the camera's intrinsics are not known. {}ive {} FILE; or give {} F for a lens with little "
      "distortion (F = image width in pixels x focal length / sensor width); or have the images tell: ulf "
      "capture with {} refine, or ulf track {} --intrinsics refine --calibration-out FILE{}",
      info.uri,
      is_taken ? "G"
               : fmt::format("Print a target (ulf board) and calibrate: ulf calibrate {}; or g",
                             ShellWord(info.uri)),
      Parameter("calibration"), Parameter("focal_px"), Parameter("intrinsics"), ShellWord(info.uri),
      stored.empty() ? ""
                     : fmt::format(". {} {}",
                                   is_taken ? "A calibration of its camera is looked for as"
                                            : "The calibration is then stored as",
                                   stored.string()));
}

}  // namespace

LensOrigin OriginOfSource(std::string_view source) {
  return source == kFocalLengthGiven     ? LensOrigin::kGiven
         : source == kFocalLengthGuessed ? LensOrigin::kGuessed
                                         : LensOrigin::kMeasured;
}

double GuessFocalPx(const Frame& frame) {
  const double wide = frame.image.width(), high = frame.image.height();
  if (frame.encoded)
    if (const auto focal_px = FocalPx(ReadExif(*frame.encoded->bytes), wide, high)) return *focal_px;
  constexpr double kOrdinary =
      0.85;  // of the longer side: 61 degrees, between telephones, webcams and a 35 mm lens
  return kOrdinary * std::max(wide, high);
}

fs::path StoredCalibrationPath(const std::string& serial) {
  return ConfigurationFolder() / "ulf" / "calibrations" / FileName(serial);
}

fs::path StoredCalibrationPath(const CameraIdentity& identity) {
  if (!identity.serial.empty()) return StoredCalibrationPath(identity.serial);
  if (identity.model.empty() || identity.bus == "files") return {};
  return ConfigurationFolder() / "ulf" / "calibrations" / FileName(identity.model + "_" + identity.bus);
}

ResolvedCalibration ResolveCalibration(const Device& device, const IntrinsicsArgs& args, int width,
                                       int height, const std::string& mode) {
  ResolvedCalibration resolved = Resolve(device, args, width, height, mode);
  if (args.focal_px && resolved.origin != LensOrigin::kGiven)
    resolved.warnings.push_back(fmt::format("{} {:g} is not used: the camera's intrinsics are known ({})",
                                            Parameter("focal_px"), *args.focal_px, resolved.source));
  return resolved;
}

CameraModel ResolveIntrinsics(const Device& device, const IntrinsicsArgs& args, int width, int height,
                              std::string* source, LensOrigin* origin) {
  ResolvedCalibration resolved = ResolveCalibration(device, args, width, height);
  for (const std::string& warning : resolved.warnings) spdlog::warn("{}", warning);
  if (source) *source = resolved.source;
  if (origin) *origin = resolved.origin;
  return resolved.camera;
}

}  // namespace ulf::acquisition
