#include "commands/options/tracking_options.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <filesystem>
#include <map>

#include "acquisition/calibration/calibration_io.h"
#include "commands/options/command_line.h"
#include "commands/options/option_values.h"
#include "core/base/error.h"
#include "core/base/output_path.h"
#include "core/base/shell_word.h"

namespace ulf::commands {

void AddIntrinsicsOptions(CLI::App& command, acquisition::IntrinsicsArgs& args) {
  command.add_option("--calibration", args.calibration_path,
                     "Calibration file of ulf or another program, see 'ulf calibration' (default: the one "
                     "stored for this camera, else the device's own)");
  command
      .add_option("--focal-px", args.focal_px,
                  "Focal length in pixels, without a calibration; the principal point is the image centre")
      ->check(Positive());
  command.add_flag("--force-calibration", args.force, "Accept a calibration file of another camera");
}

namespace {

// `report` allows the word "report".
CLI::Validator IsReadout(bool report) {
  return CLI::Validator(
      [report](const std::string& text) {
        double ms = 0;
        const bool good = text == "auto" || (report && text == "report") ||
                          (CLI::detail::lexical_cast(text, ms) && std::abs(ms) <= 1000);
        return good ? std::string()
                    : "'" + text + "' is neither auto" + (report ? ", report" : "") +
                          " nor milliseconds from -1000 to 1000";
      },
      "");
}

}  // namespace

void AddReadoutOption(CLI::App& command, tracking::ReadoutArgs& args) {
  command
      .add_option_function<std::string>(
          "--readout-ms",
          [&args](const std::string& text) {
            args = {};
            if (text == "report")
              args.compensate_found = false;
            else if (text != "auto")
              args.readout_s = 1e-3 * std::stod(text);
          },
          "Rolling shutter: milliseconds from the first row to the last (below 0: read from the last; 0: "
          "global), auto: compensated when found (default), or report: only reported")
      ->check(IsReadout(true))
      ->type_name("MS|auto|report");
}

void AddReadoutOption(CLI::App& command, std::optional<double>& readout_s) {
  command
      .add_option_function<std::string>(
          "--readout-ms",
          [&readout_s](const std::string& text) {
            readout_s = text == "auto" ? std::nullopt : std::optional(1e-3 * std::stod(text));
          },
          "Rolling shutter: milliseconds from the first row to the last (below 0: read from the last; 0: "
          "global), or auto: what the capture measured or was given (default)")
      ->check(IsReadout(false))
      ->type_name("MS|auto");
}

constexpr int kSmallestTrackingSide = 160, kLargestTrackingSide = 20000;  // px

void AddTrackingSideOption(CLI::App& command, int& side_px) {
  command
      .add_option_function<std::string>(
          "--tracking-side",
          [&side_px](const std::string& text) { side_px = text == "full" ? 0 : std::stoi(text); },
          "Longer side that larger pictures are reduced to for tracking, px, or full: tracked as they come. "
          "Poses and intrinsics are those of the pictures as they come")
      ->check([](const std::string& text) {
        int px = 0;
        const bool good = text == "full" || text == "0" ||
                          (CLI::detail::lexical_cast(text, px) && px >= kSmallestTrackingSide &&
                           px <= kLargestTrackingSide);
        return good ? std::string()
                    : "'" + text + "' is neither full nor a whole number of pixels from " +
                          std::to_string(kSmallestTrackingSide) + " to " +
                          std::to_string(kLargestTrackingSide);
      })
      ->type_name("PX|full")
      ->default_str(std::to_string(tracking::TrackerOptions{}.max_side_px));
}

void AddLensUseOptions(CLI::App& command, LensUseArgs& args) {
  static const std::map<std::string, tracking::LensUse> kWords{{"fixed", tracking::LensUse::kFixed},
                                                               {"check", tracking::LensUse::kCheck},
                                                               {"refine", tracking::LensUse::kRefine}};
  command
      .add_option_function<std::string>(
          "--intrinsics",
          [&args](const std::string& word) {
            args.use = kWords.at(word);
            args.is_asked = true;
          },
          "The lens while tracking: fixed (as given), check (as given; said where images contradict it), "
          "refine (where they do, tracking goes on with the lens that fits, and the poses so far follow; "
          "where no lens is known it starts from a guess) (check; refine for a recording or photographs of "
          "whose lens nothing is known)")
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
        "of the focal length, 4 % of distortion in the corners, 2 % of the width for the principal point). "
        "'ulf refine DIR --intrinsics' on a capture finds smaller differences{}",
        path, IsTaken(device.Source()) ? "" : "; so do views from nearer, farther and around, for longer");
  const acquisition::ModeCalibration calibration{.camera = lens->camera};
  acquisition::UpdateCalibration(path, acquisition::CameraIdentity::Of(device.Info()),
                                 command + " --intrinsics refine", "live", calibration);
}

void RequireOwnCalibration(const std::string& output) {
  RequireWritable(output);
  if (!std::filesystem::is_regular_file(output)) return;
  std::string convert;
  try {
    if (acquisition::ReadCalibrationFile(output).is_ours) return;
    convert = fmt::format(", or convert it first: ulf calibration {} -o camera.json", ShellWord(output));
  } catch (const Error&) {
    // A file that is no calibration cannot be converted.
  }
  throw UsageError(
      "{}: exists already, is no calibration file of ulf, and is not replaced; choose another name{}", output,
      convert);
}

}  // namespace ulf::commands
