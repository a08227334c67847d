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
  std::vector<std::string> sources;    // a device's URI, or files and folders of images, or a video
  std::string board = Board().Text();  // in the form of core/fiducials/board.h
  std::string mode = "live";           // "live", or "still" for photographs of a tethered camera
  std::string output;                  // calibration file; empty: CalibrationOutput() chooses it
  std::string report;                  // folder for report and frames; empty: none
  std::string preview;                 // PNG file of the live picture; empty: a window
  std::string serial;                  // of the camera that took image files; empty: unknown
  int views = 14;                      // least number of views from a device
  int frames = 10;                     // averaged for flat field and colours
  bool flat = false, colour = false, grey = false, json = false, explain = false;
};

// The source of frames: one device, or files.
struct CalibrationSource {
  std::unique_ptr<acquisition::Device> device;  // null: files
  std::vector<std::string> files;               // images; empty with a device
  acquisition::CameraIdentity identity;
  std::optional<SensorWindow> window;  // part of the sensor in the images; none: unknown
  std::optional<CameraModel> truth;    // intrinsics that the device knows itself (the simulator)
  std::string name;                    // for messages

  FrameSource Frames() const { return device ? device->Source() : FrameSource::kPhotographs; }
  // Returns the beginning of advice: pictures that are taken already cannot be improved, others can be taken.
  std::string RetakeAdvice() const {
    return IsTaken(Frames()) ? "these pictures do not do, take others: " : "";
  }
};

// Throws as OpenDevice() and ImagesIn() do.
CalibrationSource OpenCalibrationSource(const CalibrateArgs& args);

// Returns the named file, or the stored one of the camera, or one in this folder. Throws if it cannot be
// written.
std::string CalibrationOutput(const CalibrateArgs& args, const CalibrationSource& source);

// Throws if the report's folder cannot be written; called before frames are taken.
void RequireReportFolder(const CalibrateArgs& args);

// Returns options that show progress until a signal asks to stop; `progress` must outlive them.
acquisition::CalibrationCaptureOptions CaptureOptions(const CalibrateArgs& args, Progress& progress);

// Calibrates intrinsics with a board (board_calibration.cpp).
int RunBoardCalibration(const CalibrateArgs& args);

}  // namespace ulf::commands
