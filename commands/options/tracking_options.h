// The options of the commands that read frames and track them: intrinsics, the lens while tracking, the
// shutter's readout, the size of the tracked pictures.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::commands {

// Adds --calibration, --focal-px and --force-calibration. `args` must outlive the parsing, here and below.
void AddIntrinsicsOptions(CLI::App& command, acquisition::IntrinsicsArgs& args);

// Adds --readout-ms, the time from the first to the last row of a rolling shutter.
void AddReadoutOption(CLI::App& command, tracking::ReadoutArgs& args);
// Does the same for recorded views, without measuring: `readout_s` is in seconds, none for "auto".
void AddReadoutOption(CLI::App& command, std::optional<double>& readout_s);

// Adds --tracking-side, the longer side of the tracked pictures in px.
void AddTrackingSideOption(CLI::App& command, int& side_px);

// The values of --intrinsics and --calibration-out.
struct LensUseArgs {
  tracking::LensUse use = tracking::LensUse::kCheck;  // whether images may check or refine the lens
  std::string calibration_output;                     // file for the estimated lens; empty: none is written
};

void AddLensUseOptions(CLI::App& command, LensUseArgs& args);

// Throws UsageError if a file is to be written and no lens is estimated, and Error if it cannot be written.
void RequireUsable(const LensUseArgs& args);

// Writes the estimated lens to args.calibration_output, if that is given; logs if none was found, and if
// images still contradict it (`at_end`). `command` is noted in the file: "ulf track".
void WriteFoundLens(const LensUseArgs& args, const acquisition::Device& device,
                    const std::optional<tracking::RefinedLens>& lens,
                    const std::optional<tracking::CalibrationCheck>& at_end, const std::string& command);

// Throws UsageError if the file cannot be written, or exists and is no calibration file of ulf, because
// results would replace the file of another program.
void RequireOwnCalibration(const std::string& output);

}  // namespace ulf::commands
