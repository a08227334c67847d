// The arguments of `ulf calibrate`, the source of its pictures, and the place of its results.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_capture.h"
#include "acquisition/calibration/calibration_io.h"
#include "core/base/progress.h"
#include "core/geometry/sensor_window.h"

namespace ulf::commands {

struct CalibrateArgs {
  std::vector<std::string> sources;
  std::string board = Board().Text();
  std::string mode = "live";
  std::string output;
  std::string report;
  std::string preview;
  std::string serial;
  int views = 14;
  int frames = 10;
  bool flat = false, colour = false, grey = false, json = false, explain = false;
};

// The source of frames: one device, or files.
struct CalibrationSource {
  std::unique_ptr<acquisition::Device> device;
  std::vector<std::string> files;
  acquisition::CameraIdentity identity;
  std::optional<SensorWindow> window;
  std::optional<CameraModel> truth;
  std::string name;

  FrameSource Frames() const { return device ? device->Source() : FrameSource::kPhotographs; }
  // Returns the beginning of advice: pictures that are taken already cannot be improved, others can be taken.
  std::string TakeOthers() const {
    return IsTaken(Frames()) ? "these pictures do not do, take others: " : "";
  }
};

// Throws as OpenDevice() and ImagesIn() do.
CalibrationSource OpenCalibrationSource(const CalibrateArgs& args);

// Returns the named file, or the stored one of the camera, or one in this folder. Throws if it cannot be
// written.
std::string CalibrationOutput(const CalibrateArgs& args, const CalibrationSource& source);

// Checks before frames are taken, so that the user does not hold the board in vain.
void RequireReportFolder(const CalibrateArgs& args);

// Returns options that show progress until a signal asks to stop; `progress` must outlive them.
acquisition::CalibrationCaptureOptions CaptureOptions(const CalibrateArgs& args, Progress& progress);

// Calibrates intrinsics with a board (board_calibration.cpp).
int RunBoardCalibration(const CalibrateArgs& args);

}  // namespace ulf::commands
