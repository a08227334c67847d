#include "acquisition/calibration/calibration_io.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <optional>
#include <sstream>
#include <vector>

#include "acquisition/calibration/lens_files/lens_files.h"
#include "core/base/atomic_file.h"
#include "core/base/binary_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/camera_json.h"

namespace ulf::acquisition {
namespace {

std::string ReadText(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path))
    throw Error("{}: is a folder; give the calibration file in it (a light field: ulf info)", path.string());
  if (!std::filesystem::is_regular_file(path))
    throw Error("{}: there is no such calibration file; check the path, or calibrate (ulf calibrate)",
                path.string());
  const std::string text = ReadWholeFile(path);
  return text.starts_with(kByteOrderMark) ? text.substr(kByteOrderMark.size()) : text;
}

// Returns the words of a line of numbers; none: something else stands there.
std::optional<std::vector<double>> LineOfNumbers(const std::string& text) {
  std::istringstream lines(text);
  std::vector<double> numbers;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    for (std::string word; words >> word;) {
      std::size_t used = 0;
      double value = 0;
      try {
        value = std::stod(word, &used);
      } catch (const std::exception&) {
        used = 0;
      }
      if (used != word.size()) return std::nullopt;
      numbers.push_back(value);
    }
  }
  return numbers;
}

CameraModel FromNumbers(const std::vector<double>& numbers, const std::string& where) {
  if (numbers.size() != 10 && numbers.size() != 11)
    throw Error(
        "{}: {} numbers where 10 or 11 are expected: fx fy cx cy k1 k2 p1 p2 width height [fps]; a camera "
        "matrix alone tells neither size nor distortion: write it as an OpenCV file (image_width, "
        "image_height, camera_matrix, distortion_coefficients)",
        where, numbers.size());
  constexpr double kMostPx = 1 << 20;
  for (const double side : {numbers[8], numbers[9]})
    if (!(side >= 1 && side <= kMostPx) || side != std::floor(side))
      throw Error("{}: width and height must be whole numbers from 1 to {:.0f} px, not {}", where, kMostPx,
                  side);
  CameraModel camera = CameraModel::FromOpenCv(
      static_cast<int>(numbers[8]), static_cast<int>(numbers[9]), numbers[0], numbers[1], numbers[2],
      numbers[3], Distortion::kRadialTangential, {numbers[4], numbers[5], numbers[6], numbers[7], 0});
  camera.Validate(where);
  return camera;
}

CalibrationFile FileOfLens(Lens lens, const std::string& source) {
  return {{}, source, {{"live", {lens.camera}}}, std::move(lens.warnings)};
}

nlohmann::json ModeToJson(const ModeCalibration& mode) {
  nlohmann::json json = CameraToJson(mode.camera);
  if (mode.window) json["sensor"] = WindowToJson(*mode.window);
  if (mode.sigma) json["sigma"] = *mode.sigma;
  if (mode.rms_px) json["rms_px"] = *mode.rms_px;
  if (mode.flat_field) json["flat_field"] = FlatFieldToJson(*mode.flat_field);
  if (mode.color_profile) json["color_profile"] = ColorProfileToJson(*mode.color_profile);
  return json;
}

ModeCalibration ModeFromJson(const JsonPlace& place) {
  ModeCalibration mode{.camera = CameraFromJson(place)};
  if (place.Has("sensor")) mode.window = WindowFromJson({place.Raw("sensor"), place.where + ", sensor"});
  if (place.Has("sigma")) {
    const std::vector<double> values = place.Numbers("sigma", 9);
    mode.sigma.emplace();
    std::copy(values.begin(), values.end(), mode.sigma->begin());
  }
  if (place.Has("rms_px")) mode.rms_px = place.Number("rms_px");
  if (place.Has("flat_field")) mode.flat_field = FlatFieldFromJson(place.Raw("flat_field"), place.where);
  if (place.Has("color_profile"))
    mode.color_profile = ColorProfileFromJson(place.Raw("color_profile"), place.where);
  return mode;
}

CalibrationFile FromJson(const nlohmann::json& json, const std::string& where) {
  const JsonPlace top{json, where};
  const JsonPlace modes{top.Raw("modes"), where + ", modes"};
  CalibrationFile file{.is_ours = true};
  file.identity = {top.Text("serial", ""), top.Text("maker", ""), top.Text("model", ""), top.Text("bus", "")};
  file.source = top.Text("source", "");
  if (modes.object.is_object())
    for (const auto& [name, value] : modes.object.items())
      file.modes[name] = ModeFromJson({value, where + ", mode '" + name + "'"});
  return file;
}

// Returns none for JSON of another program.
std::optional<CalibrationFile> OursFromJson(const std::string& text, const std::string& where) {
  // What is no JSON may be YAML in braces, which is read or named elsewhere.
  if (!IsJson(text) && text.find("LENSMODEL_") != std::string::npos) return std::nullopt;
  const nlohmann::json json = ParseJson(text, where, "write the calibration again");
  if (!json.contains("modes") && !json.empty()) return std::nullopt;
  return FromJson(json, where);
}

}  // namespace

CalibrationFile ReadCalibrationFile(const std::filesystem::path& path, const std::string& camera) {
  const std::string text = ReadText(path), where = path.string();
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) throw Error("{}: the calibration file is empty; calibrate again", where);
  const auto require_no_choice = [&] {
    if (!camera.empty())
      throw Refused(where, "contains only one camera", fmt::format("'{}' must be left out", camera));
  };
  if (text[first] == '{')
    if (auto ours = OursFromJson(text, where)) {
      require_no_choice();
      return *ours;
    }
  const auto numbers = LineOfNumbers(text);
  const bool is_line = numbers && (numbers->size() == 10 || numbers->size() == 11);
  // Other numbers alone may be of another program, which its marks in the text name.
  auto read = is_line ? std::nullopt : ReadLensText(text, where, camera);
  if (numbers && !read) {
    require_no_choice();
    Lens lens{FromNumbers(*numbers, where), {}};
    CheckLensNumbers(lens, where);
    return FileOfLens(std::move(lens), "line of numbers");
  }
  if (!read) throw Error("{}: is no calibration that ulf knows. {}", where, ReadableLensFiles());
  return FileOfLens(read->lens, read->program + " file");
}

ModeCalibration ModeOf(const CalibrationFile& file, const std::string& mode, const std::string& where) {
  if (const auto found = file.modes.find(mode); found != file.modes.end()) return found->second;
  std::string list;
  for (const auto& [name, value] : file.modes) list += (list.empty() ? "" : ", ") + name;
  throw Error("{}: there is no mode '{}' (there are: {}); calibrate the camera in that mode", where, mode,
              list.empty() ? "none" : list);
}

void WriteCalibrationFile(const std::filesystem::path& path, const CalibrationFile& file) {
  nlohmann::json json{{"serial", file.identity.serial}, {"source", file.source}};
  if (!file.identity.maker.empty()) json["maker"] = file.identity.maker;
  if (!file.identity.model.empty()) json["model"] = file.identity.model;
  if (!file.identity.bus.empty()) json["bus"] = file.identity.bus;
  for (const auto& [name, mode] : file.modes) {
    mode.camera.Validate("the calibration to be written to " + path.string());
    json["modes"][name] = ModeToJson(mode);
  }
  WriteFileAtomically(path, JsonText(json, 2) + "\n");
}

void UpdateCalibration(const std::filesystem::path& path, const CameraIdentity& identity,
                       const std::string& source, const std::string& mode,
                       const ModeCalibration& calibration) {
  CalibrationFile file;
  if (std::filesystem::exists(path)) {
    file = ReadCalibrationFile(path);
    const bool unbound = file.identity.serial.empty() && file.identity.model.empty();
    const bool same = identity.serial.empty()
                          ? file.identity.serial.empty() && file.identity.model == identity.model
                          : file.identity.serial == identity.serial;
    if (!unbound && !same)
      throw Error(
          "{}: contains the calibration of another camera ('{}' {}; this one is '{}' {}); name another file",
          path.string(), file.identity.serial, file.identity.model, identity.serial, identity.model);
    if (!same) file = {};
  }
  ModeCalibration entry = calibration;
  if (const auto old = file.modes.find(mode); old != file.modes.end()) {
    if (!entry.flat_field && old->second.window == calibration.window)
      entry.flat_field = old->second.flat_field;
    if (!entry.color_profile) entry.color_profile = old->second.color_profile;
  }
  file.identity = identity;
  file.source = source;
  file.modes[mode] = entry;
  WriteCalibrationFile(path, file);
}

CameraModel ReadCalibration(const std::filesystem::path& path, const std::string& mode) {
  const CalibrationFile file = ReadCalibrationFile(path);
  for (const std::string& warning : file.warnings) spdlog::warn("{}", warning);
  return ModeOf(file, mode, path.string()).camera;
}

void WriteCalibration(const std::filesystem::path& path, const CameraModel& camera, const std::string& serial,
                      const std::string& source, const std::string& mode) {
  UpdateCalibration(path, {.serial = serial, .maker = {}, .model = {}, .bus = {}}, source, mode,
                    {.camera = camera});
}

}  // namespace ulf::acquisition
