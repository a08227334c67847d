// The options `--intrinsics` and `--calibration-out` of the commands that track.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "acquisition/device/device.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::commands {

struct LensUseArgs {
  tracking::LensUse use = tracking::LensUse::kCheck;
  std::string calibration_output;  // file for the lens that is found; empty: none is written
};

void AddLensUseOptions(CLI::App& command, LensUseArgs& args);

// Throws UsageError where a file is to be written and no lens is sought, and Error where it cannot be written.
void RequireUsable(const LensUseArgs& args);

// Writes the lens that was found to args.calibration_output, if that is given; says so where none was found, and where
// images contradict it still (`at_end`). `command`: "ulf track", for the file.
void WriteFoundLens(const LensUseArgs& args, const acquisition::Device& device,
                    const std::optional<tracking::RefinedLens>& lens,
                    const std::optional<tracking::CalibrationCheck>& at_end, const std::string& command);

}  // namespace ulf::commands
