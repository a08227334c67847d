// The options of the commands that read frames and track them: intrinsics, the lens while tracking, the
// shutter's readout, the size of the pictures that are tracked.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::commands {

// --calibration, --focal-px and --force-calibration. `args` must outlive the parsing, here and below.
void AddIntrinsicsOptions(CLI::App& command, acquisition::IntrinsicsArgs& args);

// --readout-ms.
void AddReadoutOption(CLI::App& command, tracking::ReadoutArgs& args);
// Of recorded views: nothing is measured.
void AddReadoutOption(CLI::App& command, std::optional<double>& readout_s);

// --tracking-side.
void AddTrackingSideOption(CLI::App& command, int& side_px);

// --intrinsics and --calibration-out.
struct LensUseArgs {
  tracking::LensUse use = tracking::LensUse::kCheck;
  std::string calibration_output;  // file for the lens that is found; empty: none is written
};

void AddLensUseOptions(CLI::App& command, LensUseArgs& args);

// Throws UsageError where a file is to be written and no lens is sought, and Error where it cannot be
// written.
void RequireUsable(const LensUseArgs& args);

// Writes the lens that was found to args.calibration_output, if that is given; says so where none was found,
// and where images contradict it still (`at_end`). `command`: "ulf track", for the file.
void WriteFoundLens(const LensUseArgs& args, const acquisition::Device& device,
                    const std::optional<tracking::RefinedLens>& lens,
                    const std::optional<tracking::CalibrationCheck>& at_end, const std::string& command);

// Throws UsageError where the file cannot be written, or is there and is no calibration file of ulf: results
// are written into one of ulf, and one of another program would be lost.
void RequireOwnCalibration(const std::string& output);

}  // namespace ulf::commands
