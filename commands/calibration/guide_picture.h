// Shows the operator of a calibration the live picture with its guidance, in a window or in a file, and lets
// the Enter key release a photograph.
#pragma once

#include "acquisition/calibration/calibration_capture.h"
#include "commands/calibration/calibrate_source.h"
#include "core/base/progress.h"

namespace ulf::commands {

// Sets the callbacks of `options` (none for files). The file of --preview is rewritten every second and for
// each view; without it, a window opens if messages go to a terminal. Closing the window ends the calibration
// as Ctrl-C does. Throws UsageError for --preview without a device or without the ending .png, Refusal if the
// file cannot be written. `progress` must outlive `options`.
void ShowGuide(const CalibrateArgs& args, bool is_device, Progress& progress,
               acquisition::CalibrationCaptureOptions& options);

}  // namespace ulf::commands
