// Defines the arguments of `ulf calibrate`, opens the source of its pictures, and chooses its output files.
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
  std::vector<std::string> sources;    // a device's URI, or files and folders of images, or a video
  std::string board = Board().Text();  // in the form of core/fiducials/board.h
  std::string mode = "live";           // "live", or "still" for photographs of a tethered camera
  std::string output;                  // calibration file; empty: CalibrationOutput() chooses it
  std::string report;                  // folder for report and frames; empty: none
  std::string preview;                 // PNG file of the live picture; empty: a window
  std::string serial;                  // serial number of the camera; empty: the device's, or unknown
  int views = 14;                      // least number of views from a device
  int frames = 10;                     // number of frames averaged for flat field and colours
  bool flat = false, colour = false, grey = false, json = false, explain = false;
};

// The source of the pictures: one device (a video is one, too), or image files.
struct CalibrationSource {
  std::unique_ptr<acquisition::Device> device;  // null: files
  std::vector<std::string> files;               // images; empty with a device
  acquisition::CameraIdentity identity;         // empty for images of an unknown camera
  std::optional<SensorWindow> window;           // part of the sensor in live images; none: unknown
  std::optional<CameraModel> truth;             // true intrinsics of the simulator; else none
  std::string name;                             // for messages

  FrameSource Frames() const { return device ? device->Source() : FrameSource::kPhotographs; }
  // Returns the beginning of advice on pictures that cannot be taken again; "" while others can be taken.
  std::string RetakeAdvice() const {
    return IsTaken(Frames()) ? "these pictures do not do, take others: " : "";
  }
};

// Throws as OpenDevice() and ImagesIn() do, and UsageError for a video among other files.
CalibrationSource OpenCalibrationSource(const CalibrateArgs& args);

// Returns the calibration file to write: `args.output`, else the file where commands look for this camera's,
// else (unknown camera) a new name in the working directory. Throws Refusal as RequireOwnCalibration() does.
std::string CalibrationOutput(const CalibrateArgs& args, const CalibrationSource& source);

// Makes the report's folder, if one is asked for. Throws Refusal if it cannot be written into.
void RequireReportFolder(const CalibrateArgs& args);

// Returns options that report to `progress`, which must outlive them, and stop on a signal (stop_signal.h).
acquisition::CalibrationCaptureOptions CaptureOptions(const CalibrateArgs& args, Progress& progress);

// Calibrates intrinsics with a board, prints and stores them (board_calibration.cpp). Returns kOk; throws
// Error if the pictures give no calibration.
int RunBoardCalibration(const CalibrateArgs& args);

}  // namespace ulf::commands
