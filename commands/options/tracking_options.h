// The options of the commands that track frames: intrinsics, whether images may change them, the readout time
// of a rolling shutter, the size of the tracked pictures.
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
// Does the same for recorded views, whose readout is not measured: `readout_s` is none for "auto".
void AddReadoutOption(CLI::App& command, std::optional<double>& readout_s);

// Adds --tracking-side, the longer side to which larger pictures are reduced, px; 0 for "full": not reduced.
void AddTrackingSideOption(CLI::App& command, int& side_px);

// The values of --intrinsics and --calibration-out.
struct LensUseArgs {
  tracking::LensUse use = tracking::LensUse::kCheck;  // whether images may check or refine the lens
  bool is_asked = false;                              // `use` was given
  std::string calibration_output;                     // file for the estimated lens; empty: none is written
};

void AddLensUseOptions(CLI::App& command, LensUseArgs& args);

// Throws UsageError for a file to write if no lens is estimated, and as RequireOwnCalibration() does.
void RequireUsable(const LensUseArgs& args);

// Writes the estimated lens to args.calibration_output, if that is given, with `command` ("ulf track") as its
// origin. Logs why and writes nothing if `lens` is none, or if `at_end` says that no real lens fits.
void WriteFoundLens(const LensUseArgs& args, const acquisition::Device& device,
                    const std::optional<tracking::RefinedLens>& lens,
                    const std::optional<tracking::CalibrationCheck>& at_end, const std::string& command);

// Throws Refusal if the file cannot be written, and UsageError if it exists and is no calibration file of
// ulf: files of other programs are not replaced.
void RequireOwnCalibration(const std::string& output);

}  // namespace ulf::commands
