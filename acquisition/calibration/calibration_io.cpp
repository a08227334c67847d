#include "acquisition/calibration/calibration_io.h"

#include <sstream>
#include <vector>

#include "acquisition/atomic_file.h"
#include "acquisition/camera_json.h"
#include "acquisition/error.h"

namespace ulf {
namespace {

std::string ReadText(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path))
    throw Error("{}: there is no such calibration file; check the path, or calibrate (ulf calibrate)",
                path.string());
  return ReadWholeFile(path);
}

CameraModel FromNumbers(const std::string& text, const std::string& where) {
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
      if (used != word.size())
        throw Error("{}: neither JSON nor numbers: '{}'; expected fx fy cx cy k1 k2 p1 p2 width height",
                    where, word.substr(0, 40));
      numbers.push_back(value);
    }
  }
  if (numbers.size() != 10 && numbers.size() != 11)
    throw Error("{}: {} numbers where 10 or 11 are expected: fx fy cx cy k1 k2 p1 p2 width height [fps]",
                where, numbers.size());
  CameraModel camera = CameraModel::FromOpenCv(
      static_cast<int>(numbers[8]), static_cast<int>(numbers[9]), numbers[0], numbers[1], numbers[2],
      numbers[3], Distortion::kRadialTangential, {numbers[4], numbers[5], numbers[6], numbers[7], 0});
  camera.Validate(where);
  return camera;
}

nlohmann::json ParseJson(const std::string& text, const std::string& where) {
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    throw Error("{}: not valid JSON at byte {}; write the calibration again", where, error.byte);
  }
}

}  // namespace

CameraModel ReadCalibration(const std::filesystem::path& path, const std::string& mode) {
  const std::string text = ReadText(path), where = path.string();
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) throw Error("{}: the calibration file is empty; calibrate again", where);
  if (text[first] != '{') return FromNumbers(text, where);
  const nlohmann::json file = ParseJson(text, where);
  const JsonPlace top{file, where};
  const JsonPlace modes{top.Raw("modes"), where + ", modes"};
  if (!modes.object.is_object() || !modes.Has(mode.c_str())) {
    std::string list;
    if (modes.object.is_object())
      for (const auto& [name, value] : modes.object.items()) list += (list.empty() ? "" : ", ") + name;
    throw Error("{}: there is no mode '{}' (there are: {}); calibrate the camera in that mode", where, mode,
                list.empty() ? "none" : list);
  }
  return CameraFromJson({modes.Raw(mode.c_str()), where + ", mode '" + mode + "'"});
}

void WriteCalibration(const std::filesystem::path& path, const CameraModel& camera, const std::string& serial,
                      const std::string& source, const std::string& mode) {
  camera.Validate("the calibration to be written to " + path.string());
  nlohmann::json file;
  if (std::filesystem::exists(path)) {
    const nlohmann::json old = nlohmann::json::parse(ReadText(path), nullptr, false);
    const bool same = old.is_object() && old.contains("modes") && old["modes"].is_object() &&
                      old.contains("serial") && old["serial"] == serial;
    if (same) file["modes"] = old["modes"];
  }
  file["modes"][mode] = CameraToJson(camera);
  file["serial"] = serial;
  file["source"] = source;
  WriteFileAtomically(path, file.dump(2) + "\n");
}

}  // namespace ulf
