// `ulf calibration`: prints a calibration file and converts it to other formats.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "acquisition/calibration/calibration_formats.h"
#include "acquisition/calibration/calibration_io.h"
#include "acquisition/calibration/intrinsics.h"
#include "acquisition/calibration/lens_files/lens_files.h"
#include "commands/options/command_line.h"
#include "commands/options/subcommands.h"
#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/base/output_path.h"
#include "core/geometry/camera_json.h"
#include "core/geometry/sensor_window.h"

namespace ulf::commands {
namespace {

struct CalibrationArgs {
  std::string path, output, to, camera, mode = "live";
  std::string serial, model, sensor, roi, binning;
  bool json = false;

  bool Binds() const {
    return !serial.empty() || !model.empty() || !sensor.empty() || !roi.empty() || !binning.empty();
  }
};

template <typename... Numbers>
bool Parse(const std::string& text, const char* form, int count, Numbers*... numbers) {
  char rest = 0;
  return std::sscanf(text.c_str(), form, numbers..., &rest) == count;
}

// Parses the part of the sensor as in a device's URI: the region counts pixels of the image, after binning.
SensorWindow WindowOf(const CalibrationArgs& args, const CameraModel& camera) {
  SensorWindow window;
  if (!Parse(args.sensor, "%dx%d%c", 2, &window.sensor_width, &window.sensor_height))
    throw UsageError("--sensor {}: must be WIDTHxHEIGHT of the whole sensor in pixels{}", args.sensor,
                     args.sensor.empty() ? ", and is needed with --roi and --binning" : "");
  if (!args.binning.empty() && !Parse(args.binning, "%dx%d%c", 2, &window.binning_x, &window.binning_y))
    throw UsageError("--binning {}: must read 2x2", args.binning);
  if (window.binning_x < 1 || window.binning_y < 1)
    throw UsageError("--binning {}: less than 1", args.binning);
  int width = camera.width, height = camera.height, x = 0, y = 0;
  if (!args.roi.empty() && !Parse(args.roi, "%dx%d+%d+%d%c", 4, &width, &height, &x, &y))
    throw UsageError("--roi {}: must read WIDTHxHEIGHT+X+Y", args.roi);
  if (width != camera.width || height != camera.height)
    throw UsageError(
        "--roi {}: the calibration is for {}x{} images; calibrate that part, or give the part of these "
        "images",
        args.roi, camera.width, camera.height);
  window.x = x * window.binning_x;
  window.y = y * window.binning_y;
  window.width = width * window.binning_x;
  window.height = height * window.binning_y;
  const bool whole = window.width == window.sensor_width / window.binning_x * window.binning_x &&
                     window.height == window.sensor_height / window.binning_y * window.binning_y;
  if (args.roi.empty() && !whole)
    throw UsageError(
        "--sensor {}: the calibration's {}x{} are not the whole sensor{}; give the part with --roi "
        "{}x{}+X+Y, or the binning with --binning",
        args.sensor, width, height, args.binning.empty() ? "" : " at this binning", width, height);
  if (x < 0 || y < 0 || window.x + window.width > window.sensor_width ||
      window.y + window.height > window.sensor_height)
    throw UsageError("--roi {}: reaches beyond the sensor of {}", args.roi, args.sensor);
  return window;
}

// Adds what files of other programs do not contain: the camera and the part of its sensor.
void Bind(const CalibrationArgs& args, acquisition::CalibrationFile& file) {
  if (!args.serial.empty() && !file.identity.serial.empty() && file.identity.serial != args.serial)
    throw UsageError(
        "--serial {}: {} is already bound to '{}'; a calibration belongs to one camera: calibrate the other "
        "one (ulf calibrate), or use this file for both when capturing (--force-calibration)",
        args.serial, args.path, file.identity.serial);
  if (!args.model.empty() && !file.identity.model.empty() && file.identity.model != args.model)
    throw UsageError("--model {}: {} is already bound to a '{}'", args.model, args.path, file.identity.model);
  if (!args.serial.empty()) file.identity.serial = args.serial;
  if (!args.model.empty()) file.identity.model = args.model;
  if (args.sensor.empty() && args.roi.empty() && args.binning.empty()) return;
  acquisition::ModeOf(file, args.mode, args.path);
  acquisition::ModeCalibration& mode = file.modes[args.mode];
  const SensorWindow window = WindowOf(args, mode.camera);
  if (mode.window && *mode.window != window)
    throw UsageError("{}: contains already which part of the sensor it covers ({}); calibrate again",
                     args.path, Describe(*mode.window));
  mode.window = window;
}

// Returns none for ulf's own format. Throws UsageError if neither --to nor the file's name determines it.
std::optional<acquisition::CalibrationFormat> FormatOf(const CalibrationArgs& args) {
  if (args.to == "ulf") return std::nullopt;
  if (!args.to.empty()) {
    const auto to = acquisition::CalibrationFormatByName(args.to);
    if (!to) throw UsageError("--to {}: there are ulf, kalibr, ros, opencv and colmap", args.to);
    return to;
  }
  const std::string extension = std::filesystem::path(args.output).extension();
  if (args.output.empty() || extension == ".json") return std::nullopt;
  if (extension == ".xml") return acquisition::CalibrationFormat::kOpenCv;
  if (extension == ".txt") return acquisition::CalibrationFormat::kColmap;
  if (extension == ".yaml" || extension == ".yml")
    throw UsageError("-o {}: Kalibr, ROS and OpenCV all write {}; choose one: --to kalibr, ros or opencv",
                     args.output, extension);
  throw UsageError(
      "-o {}: the name does not determine the format; end it in .json (ulf), .xml (OpenCV) or .txt (COLMAP), "
      "or give --to ulf, kalibr, ros, opencv or colmap",
      args.output);
}

void Print(const acquisition::CalibrationFile& file) {
  const acquisition::CameraIdentity& id = file.identity;
  if (!id.serial.empty() || !id.model.empty())
    fmt::print("camera           {}{}{}serial {}\n", id.maker, id.maker.empty() ? "" : " ",
               id.model.empty() ? "" : id.model + ", ",
               !id.serial.empty() ? id.serial
               : id.bus.empty()   ? "unknown"
                                  : "unknown, at " + id.bus);
  else
    fmt::print(
        "camera           not bound to any; bind it: ulf calibration FILE --serial SERIAL -o NEW_FILE\n");
  fmt::print("obtained         {}\n", file.source.empty() ? "unknown" : file.source);
  for (const auto& [name, mode] : file.modes) {
    const CameraModel& c = mode.camera;
    fmt::print("mode {:<12}{} x {} px, fx {:.3f} fy {:.3f} cx {:.3f} cy {:.3f}\n", name, c.width, c.height,
               c.fx, c.fy, c.cx, c.cy);
    if (c.distortion != Distortion::kNone)
      fmt::print("  {:<15}{}\n", c.distortion == Distortion::kFisheye ? "fisheye" : "k1 k2 p1 p2 k3",
                 fmt::join(c.coefficients, " "));
    if (mode.window) fmt::print("  sensor         {}\n", Describe(*mode.window));
    if (mode.rms_px) fmt::print("  error          {:.3f} px RMS\n", *mode.rms_px);
    if (mode.flat_field) fmt::print("  flat field     yes\n");
    if (mode.color_profile)
      fmt::print("  colours        {}{}\n", mode.color_profile->source,
                 mode.color_profile->delta_e
                     ? fmt::format(", CIEDE2000 {:.2f} on patches left out", *mode.color_profile->delta_e)
                     : "");
  }
}

// Returns whether the file that is read is meant to be overwritten with all that it holds: another program's
// holds more than a lens.
bool BindsInPlace(const CalibrationArgs& args, const acquisition::CalibrationFile& file) {
  std::error_code unknown;
  return file.is_ours && std::filesystem::equivalent(args.path, args.output, unknown);
}

int RunCalibration(const CalibrationArgs& args) {
  const auto to = FormatOf(args);
  if (args.output.empty()) {
    const std::string stored = args.serial.empty()
                                   ? ""
                                   : ", such as " + acquisition::StoredCalibrationPath(args.serial).string() +
                                         " where commands find it automatically";
    if (args.Binds()) throw UsageError("{}: name the file to write (-o FILE){}", args.path, stored);
    if (!args.to.empty()) throw UsageError("--to {}: name the file to write (-o FILE)", args.to);
  } else {
    RequireWritable(args.output);
  }
  acquisition::CalibrationFile file = acquisition::ReadCalibrationFile(args.path, args.camera);
  for (const std::string& warning : file.warnings) spdlog::warn("{}", warning);
  Bind(args, file);
  if (args.output.empty()) {
    if (!args.json) {
      Print(file);
      return kOk;
    }
    nlohmann::ordered_json json{
        {"serial", file.identity.serial}, {"model", file.identity.model}, {"source", file.source}};
    for (const auto& [name, mode] : file.modes) json["modes"][name] = CameraToJson(mode.camera);
    fmt::print("{}\n", JsonText(json, 2));
    return kOk;
  }
  if (to) {
    const CameraModel camera = acquisition::ModeOf(file, args.mode, args.path).camera;
    const bool xml = std::filesystem::path(args.output).extension() == ".xml";
    const std::string name = file.identity.serial.empty() ? "camera" : file.identity.serial;
    const std::string text = acquisition::CalibrationText(*to, camera, name, xml);
    RequireUnused(args.output, text);
    WriteFileAtomically(args.output, text);
  } else {
    if (!BindsInPlace(args, file)) RequireUnused(args.output);
    acquisition::WriteCalibrationFile(args.output, file);
  }
  if (args.json)
    fmt::print("{}\n",
               nlohmann::ordered_json{{"file", args.output}, {"format", to ? Name(*to) : "ulf"}}.dump(2));
  else
    fmt::print("{}: written as {}{}\n", args.output, to ? Name(*to) : "ulf",
               to                              ? ""
               : !file.identity.serial.empty() ? ", bound to serial " + file.identity.serial
               : file.identity.model.empty()   ? ", not bound to any camera (--serial)"
                                               : "");
  return kOk;
}

}  // namespace

void AddCalibrationCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "calibration",
      "Show a calibration file of ulf or another program, or write it for another program", RunCalibration);
  command->add_option("FILE", args->path, "Calibration file; its format is detected")->required();
  command->add_option("--to", args->to,
                      "Format to write: ulf, kalibr, ros, opencv (.yml or .xml) or colmap (cameras.txt) "
                      "(default: by the name of the output)");
  command->add_option("-o,--output", args->output, "File to write");
  command->add_option("--camera", args->camera, "Camera of a file with several: cam1, left, or its number");
  command->add_option("--mode", args->mode, "Mode to write")
      ->check(CLI::IsMember({"live", "still"}))
      ->capture_default_str();
  command->add_option("--serial", args->serial,
                      "Bind the file to the camera with this serial number (ulf devices)");
  command->add_option("--model", args->model,
                      "Bind the file to this camera model, for a camera without a serial number");
  command->add_option("--sensor", args->sensor, "Size of the whole sensor, WIDTHxHEIGHT pixels");
  command->add_option(
      "--roi", args->roi,
      "Part of the sensor of this calibration, WIDTHxHEIGHT+X+Y after binning, as in the device's URI");
  command->add_option("--binning", args->binning, "Binning of this calibration, such as 2x2 (default: none)");
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer("Files of: " + fmt::format("{}", fmt::join(acquisition::ReadableLensPrograms(), ", ")) +
                  ".\n"
                  "Example: ulf calibration camera.json --to kalibr -o camchain.yaml\n"
                  "         ulf calibration camchain.yaml --camera cam1 --serial 21234567 -o camera.json\n"
                  "         ulf calibration cameras.txt --serial S1 --sensor 2048x2048 --roi 640x480+16+8 -o "
                  "camera.json");
}

}  // namespace ulf::commands
