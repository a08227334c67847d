#include "acquisition/calibration/calibration_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "acquisition/atomic_file.h"
#include "acquisition/calibration/calibration_formats.h"
#include "acquisition/calibration/calibration_io.h"
#include "acquisition/calibration/sensor_window.h"
#include "acquisition/camera_json.h"
#include "acquisition/error.h"
#include "acquisition/output_path.h"

namespace ulf {
namespace {

struct CalibrationArgs {
  std::string path, output, to, camera, mode = "live";
  bool json = false;
};

CalibrationFile Read(const CalibrationArgs& args) {
  if (args.camera.empty()) return ReadCalibrationFile(args.path);
  const std::string text = ReadWholeFile(args.path);
  const auto format = DetectCalibrationFormat(text);
  if (!format) throw UsageError("--camera {}: {} holds one camera", args.camera, args.path);
  return {{},
          std::string(Name(*format)) + " file",
          {{"live", {ReadCalibrationText(*format, text, args.path, args.camera)}}}};
}

void Print(const CalibrationFile& file) {
  const CameraIdentity& id = file.identity;
  if (!id.serial.empty() || !id.model.empty())
    fmt::print("camera           {} {}, serial {}\n", id.maker, id.model,
               id.serial.empty() ? "unknown, at " + id.bus : id.serial);
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
  }
}

int RunCalibration(const CalibrationArgs& args) {
  if (!args.output.empty()) RequireWritable(args.output);
  const auto to = CalibrationFormatByName(args.to);
  if (!args.to.empty() && args.to != "ulf" && !to)
    throw UsageError("--to {}: there are ulf, kalibr, ros, opencv and colmap", args.to);
  if (!args.to.empty() && args.output.empty())
    throw UsageError("--to {}: name the file to write (-o FILE)", args.to);
  const CalibrationFile file = Read(args);
  if (args.output.empty()) {
    if (!args.json) {
      Print(file);
      return kOk;
    }
    nlohmann::ordered_json json{
        {"serial", file.identity.serial}, {"model", file.identity.model}, {"source", file.source}};
    for (const auto& [name, mode] : file.modes) json["modes"][name] = CameraToJson(mode.camera);
    fmt::print("{}\n", json.dump(2));
    return kOk;
  }
  if (to) {
    const CameraModel camera = ModeOf(file, args.mode, args.path).camera;
    const bool xml = std::filesystem::path(args.output).extension() == ".xml";
    const std::string name = file.identity.serial.empty() ? "camera" : file.identity.serial;
    WriteFileAtomically(args.output, CalibrationText(*to, camera, name, xml));
  } else {
    WriteCalibrationFile(args.output, file);
  }
  if (args.json)
    fmt::print("{}\n",
               nlohmann::ordered_json{{"file", args.output}, {"format", to ? Name(*to) : "ulf"}}.dump(2));
  else
    fmt::print("{}: written as {}\n", args.output, to ? Name(*to) : "ulf");
  return kOk;
}

}  // namespace

void AddCalibrationCommand(CLI::App& app, ChosenCommand& chosen) {
  auto args = std::make_shared<CalibrationArgs>();
  CLI::App* command = app.add_subcommand(
      "calibration",
      "Show a calibration file (ulf, Kalibr, ROS, OpenCV, COLMAP), or write it for another program");
  command->add_option("FILE", args->path, "The file; its format is recognised")->required();
  command->add_option("--to", args->to, "ulf, kalibr, ros, opencv (.yml or .xml) or colmap (cameras.txt)");
  command->add_option("-o,--output", args->output, "File to write");
  command->add_option("--camera", args->camera,
                      "Which camera of a file with several: cam1, or COLMAP's number");
  command->add_option("--mode", args->mode, "Which mode to write")->capture_default_str();
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer(
      "Example: ulf calibration camera.json --to kalibr -o camchain.yaml\n"
      "         ulf calibration camchain.yaml --camera cam1 -o camera.json");
  command->callback([args, &chosen] { chosen = [args] { return RunCalibration(*args); }; });
}

}  // namespace ulf
