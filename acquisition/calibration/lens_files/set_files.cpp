#include "acquisition/calibration/lens_files/set_files.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <sstream>

#include "core/base/error.h"
#include "core/light_field/formats/colmap_model.h"
#include "core/light_field/formats/transforms_camera.h"

namespace ulf::acquisition {
namespace {

// Returns the rows of cameras.txt by their numbers. Throws Error where two rows have one number.
std::map<std::string, std::string> ColmapRows(const std::string& text, const std::string& where) {
  std::map<std::string, std::string> rows;
  std::istringstream in(text);
  for (std::string row; std::getline(in, row);) {
    std::istringstream words(row);
    std::string id;
    if (!(words >> id) || id[0] == '#') continue;
    const auto [known, is_new] = rows.try_emplace(id, row);
    if (!is_new && known->second != row)
      throw Error("{}: camera {} is there twice with different values; delete the wrong one", where, id);
  }
  return rows;
}

CameraModel TransformsCamera(const nlohmann::json& keys, const std::string& where) {
  const JsonPlace place{keys, where};
  if (!HasSize(place))
    throw Error("{}: the size of the pictures is missing; write it into the file (\"w\": W, \"h\": H)",
                where);
  const CameraModel camera = ReadCamera(place, {});
  // Instant-ngp writes both, and only one of the two is read.
  constexpr double kSameShare = 0.01;
  if (keys.contains("fl_x") && keys.contains("camera_angle_x")) {
    const double angle = place.Number("camera_angle_x"), fl_x = 0.5 * camera.width / std::tan(0.5 * angle);
    if (std::abs(fl_x / camera.fx - 1) > kSameShare)
      throw Error(
          "{}: 'camera_angle_x: {}' is a focal length of {:.6g} px, but 'fl_x' is {:.6g}; delete the "
          "wrong one",
          where, angle, fl_x, camera.fx);
  }
  return camera;
}

}  // namespace

bool IsColmapCameras(const std::string& text) {
  std::istringstream in(text);
  for (std::string row; std::getline(in, row);) {
    std::istringstream words(row);
    std::string number, model;
    if (!(words >> number) || number[0] == '#') continue;
    words >> model;
    return number.find_first_not_of("0123456789") == std::string::npos && model.size() > 2 &&
           std::isupper(static_cast<unsigned char>(model[0])) != 0 &&
           std::ranges::all_of(model, [](unsigned char c) {
             return std::isupper(c) != 0 || std::isdigit(c) != 0 || c == '_';
           });
  }
  return false;
}

Lens ReadColmapLens(const std::string& text, const std::string& where, const std::string& wanted) {
  const auto rows = ColmapRows(text, where);
  std::vector<std::string> ids;
  for (const auto& [id, row] : rows) ids.push_back(id);
  const std::string id = PickLens(ids, wanted, where);
  std::istringstream row(rows.at(id));
  std::string number;
  row >> number;
  return {ReadColmapCamera(row, where + ", camera " + id), {}};
}

bool IsTransformsLens(const LensNode& top) {
  const auto has_lens = [](const LensNode& map) { return map.Has("fl_x") || map.Has("camera_angle_x"); };
  if (has_lens(top)) return true;
  const LensNode* frames = top.Find("frames");
  return frames && frames->IsList() && std::ranges::any_of(frames->items, has_lens);
}

Lens ReadTransformsLens(const std::string& text, const std::string& where, const std::string& wanted) {
  const nlohmann::json json = ParseJson(text, where, "write the file again");
  const auto refuse_list = [&](const nlohmann::json& object) {
    if (object.is_object() && object.contains("distortion_params"))
      throw Error("{}: 'distortion_params' is not read; write its values as k1, k2, k3, k4, p1 and p2",
                  where);
  };
  refuse_list(json);
  const nlohmann::json set = CameraKeysOf(json);
  std::vector<CameraModel> lenses;
  if (json.contains("frames") && json["frames"].is_array())
    for (const nlohmann::json& frame : json["frames"]) {
      if (!frame.is_object()) continue;
      refuse_list(frame);
      const nlohmann::json own = CameraKeysOf(frame);
      if (own.empty() && !lenses.empty()) continue;
      const CameraModel lens = TransformsCamera(
          MergedCameraKeys(set, own), where + ", frame " + frame.value("file_path", std::string("1")));
      if (std::ranges::find(lenses, lens) == lenses.end()) lenses.push_back(lens);
    }
  if (lenses.empty()) lenses.push_back(TransformsCamera(set, where));
  std::vector<std::string> names;
  for (std::size_t i = 0; i < lenses.size(); ++i) names.push_back(std::to_string(i + 1));
  return {lenses[std::stoul(PickLens(names, wanted, where)) - 1], {}};
}

}  // namespace ulf::acquisition
