#include "commands/options/intrinsics_options.h"

#include <CLI/CLI.hpp>

#include "commands/options/option_values.h"

namespace ulf::commands {

void AddIntrinsicsOptions(CLI::App& command, acquisition::IntrinsicsArgs& args) {
  command.add_option("--calibration", args.calibration_path,
                     "Calibration file of ulf or another program, see 'ulf calibration' (default: the one "
                     "stored for this camera, "
                     "else the device's own)");
  command
      .add_option("--focal-px", args.focal_px,
                  "Focal length in pixels, without a calibration; the principal point is the image centre")
      ->check(Positive());
  command.add_flag("--force-calibration", args.force, "Accept a calibration file of another camera");
}

}  // namespace ulf::commands
