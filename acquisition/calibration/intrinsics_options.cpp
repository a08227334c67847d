#include "acquisition/calibration/intrinsics_options.h"

#include <CLI/CLI.hpp>

namespace ulf {

void AddIntrinsicsOptions(CLI::App& command, IntrinsicsArgs& args) {
  command.add_option("--calibration", args.calibration_path,
                     "Calibration file (else the one stored for the camera's serial, else the device's own)");
  command
      .add_option("--focal-px", args.focal_px,
                  "Focal length in pixels when there is no calibration; the principal point is the middle")
      ->check(CLI::PositiveNumber);
}

}  // namespace ulf
