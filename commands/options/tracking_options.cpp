#include "commands/options/tracking_options.h"

#include <spdlog/spdlog.h>

#include <map>

#include "acquisition/calibration/calibration_io.h"
#include "commands/calibration/calibrate_source.h"
#include "core/base/error.h"

namespace ulf::commands {

void AddLensUseOptions(CLI::App& command, LensUseArgs& args) {
  static const std::map<std::string, tracking::LensUse> kWords{{"fixed", tracking::LensUse::kFixed},
                                                               {"check", tracking::LensUse::kCheck},
                                                               {"refine", tracking::LensUse::kRefine}};
  command
      .add_option_function<std::string>(
          "--intrinsics", [&args](const std::string& word) { args.use = kWords.at(word); },
          "The lens while tracking: fixed (as given), check (as given; said where images contradict it), "
          "refine (where they do, tracking goes on with the lens that fits, and the poses so far follow; "
          "where "
          "no lens is known it starts from a guess) (check)")
      ->check([](const std::string& word) {
        return kWords.contains(word) ? std::string() : "'" + word + "' is none of fixed, check and refine";
      })
      ->type_name("fixed|check|refine");
  command.add_option("--calibration-out", args.calibration_output,
                     "With --intrinsics refine: calibration file to write, with the lens that was found");
}

void RequireUsable(const LensUseArgs& args) {
  if (args.calibration_output.empty()) return;
  if (args.use != tracking::LensUse::kRefine)
    throw UsageError("--calibration-out {}: the lens is found with --intrinsics refine",
                     args.calibration_output);
  RequireOwnCalibration(args.calibration_output);
}

void WriteFoundLens(const LensUseArgs& args, const acquisition::Device& device,
                    const std::optional<tracking::RefinedLens>& lens,
                    const std::optional<tracking::CalibrationCheck>& at_end, const std::string& command) {
  const std::string& path = args.calibration_output;
  if (path.empty()) return;
  if (at_end && at_end->no_lens_fits)
    return spdlog::warn("{}: no calibration is written: {}", path, at_end->Advice(device.Source()));
  if (!lens)
    return spdlog::warn(
        "{}: no calibration is written: what the images tell is within what counts as the given lens (1.5 % "
        "of the "
        "focal length, 4 % of distortion in the corners, 2 % of the width for the principal point). 'ulf "
        "refine DIR --intrinsics' on a capture finds smaller differences{}",
        path, IsTaken(device.Source()) ? "" : "; so do views from nearer, farther and around, for longer");
  const acquisition::ModeCalibration calibration{.camera = lens->camera};
  acquisition::UpdateCalibration(path, acquisition::CameraIdentity::Of(device.Info()),
                                 command + " --intrinsics refine", "live", calibration);
}

}  // namespace ulf::commands
