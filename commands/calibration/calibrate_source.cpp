#include "commands/calibration/calibrate_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/opening/open_device.h"
#include "commands/options/command_line.h"
#include "commands/options/tracking_options.h"
#include "core/base/error.h"
#include "core/base/output_path.h"
#include "core/base/stop_signal.h"
#include "core/image/files/picture_file.h"

namespace ulf::commands {

namespace fs = std::filesystem;

namespace {

// Returns whether a file is of no kind of picture, by its ending and by its bytes.
bool IsNoPicture(const std::string& path) {
  if (!fs::is_regular_file(path) || HasImageEnding(path) || UnreadPicture(path)) return false;
  try {
    return ReadImageSize(path).empty();
  } catch (const Error&) {
    return true;
  }
}

}  // namespace

CalibrationSource OpenCalibrationSource(const CalibrateArgs& args) {
  CalibrationSource source;
  source.name = args.sources[0];
  const bool is_device = args.sources.size() == 1 && !fs::exists(args.sources[0]) &&
                         args.sources[0].find(':') != std::string::npos;
  const auto video = std::ranges::find_if(args.sources, IsNoPicture);
  const bool is_video = video != args.sources.end();
  if (is_video && args.sources.size() > 1)
    throw UsageError("{}: is no picture; give pictures alone, or one video", *video);
  if (is_device || is_video) {
    source.device = acquisition::OpenDevice(is_video ? "replay:" + source.name : source.name);
    const acquisition::DeviceInfo info = source.device->Info();
    // The camera of images and videos is unknown.
    if (info.bus != "files" || !info.serial.empty()) source.identity = acquisition::CameraIdentity::Of(info);
    if (args.mode == "live") source.window = source.device->Window();
    if (args.mode == "live") source.truth = source.device->Camera();
  } else {
    source.files = acquisition::ImagesIn(args.sources);
  }
  if (!args.serial.empty()) source.identity.serial = args.serial;
  return source;
}

namespace {

// Returns a new name in this folder, for images whose camera is unknown.
fs::path UnusedCalibrationName() {
  fs::path path = "calibration.json";
  for (int number = 2; fs::exists(path); ++number) path = fmt::format("calibration-{}.json", number);
  return path;
}

}  // namespace

std::string CalibrationOutput(const CalibrateArgs& args, const CalibrationSource& source) {
  const fs::path stored = acquisition::StoredCalibrationPath(source.identity);
  if (args.output.empty() && !stored.empty()) {
    fs::create_directories(stored.parent_path());
    return stored.string();
  }
  const std::string output = args.output.empty() ? UnusedCalibrationName().string() : args.output;
  RequireOwnCalibration(output);
  return output;
}

void RequireReportFolder(const CalibrateArgs& args) {
  if (!args.report.empty()) RequireWritableFolder(args.report);
}

acquisition::CalibrationCaptureOptions CaptureOptions(const CalibrateArgs& args, Progress& progress) {
  acquisition::CalibrationCaptureOptions options;
  options.mode = args.mode;
  options.least_views = args.views;
  options.show = [&](const acquisition::CaptureProgress& now) { progress.Show(now.share, now.text); };
  options.stop = [] { return StopOnSignal::Requested(); };
  return options;
}

}  // namespace ulf::commands
