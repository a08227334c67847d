// Shows the live picture of a calibration in a window, or in a file that is rewritten every second, and lets
// the Enter key release a photograph.
#pragma once

#include "acquisition/calibration/calibration_capture.h"
#include "commands/calibration/calibrate_source.h"
#include "core/base/progress.h"

namespace ulf::commands {

// Adds them to the options. Throws UsageError for --preview without a device, or with another ending than
// .png, and Error if the file cannot be written. Closing the window ends the calibration as Ctrl-C does.
// `progress` must outlive the options.
void ShowGuide(const CalibrateArgs& args, bool is_device, Progress& progress,
               acquisition::CalibrationCaptureOptions& options);

}  // namespace ulf::commands
