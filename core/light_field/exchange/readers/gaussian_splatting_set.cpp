#include <fmt/format.h>

#include <fstream>
#include <optional>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_fields.h"
#include "core/light_field/exchange/readers/json_entries.h"
#include "core/light_field/exchange/readers/named_views.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/points/point_io.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Returns the text in quotation marks after `key=` in what Python has printed; "" if there is none.
std::string PrintedValue(const std::string& text, const std::string& key) {
  const std::size_t at = text.find(key + "='");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + key.size() + 2, end = text.find('\'', begin);
  return end == std::string::npos ? std::string() : text.substr(begin, end - begin);
}

// Returns where the program that trained has found the photographs, by its file cfg_args; none if it is not
// there, or does not lead to a folder.
std::optional<fs::path> FolderOfTraining(const fs::path& folder) {
  std::error_code unknown;
  if (!fs::is_regular_file(folder / "cfg_args", unknown)) return std::nullopt;
  const std::string text = ReadWholeFile(folder / "cfg_args");
  const std::string source = PrintedValue(text, "source_path");
  if (source.empty()) return std::nullopt;
  const std::string images = PrintedValue(text, "images");
  const fs::path found = folder / source / (images.empty() ? "images" : images);
  return fs::is_directory(found, unknown) ? std::optional(found) : std::nullopt;
}

Rigid3 TrainedPose(const JsonPlace& camera) {
  const json& rows = camera.Raw("rotation");
  if (!rows.is_array() || rows.size() != 3) throw Error("{}: 'rotation' must be three rows", camera.where);
  Eigen::Matrix3d world_from_cam;
  for (std::size_t row = 0; row < 3; ++row) {
    const json object{{"rotation", rows[row]}};
    const std::vector<double> numbers = JsonPlace{object, camera.where}.Numbers("rotation", 3);
    world_from_cam.row(static_cast<Eigen::Index>(row)) << numbers[0], numbers[1], numbers[2];
  }
  const std::vector<double> center = camera.Numbers("position", 3);
  return Rigid3{NearestRotation(world_from_cam, camera.where, "'rotation'"),
                {center[0], center[1], center[2]}}
      .Inverse();
}

}  // namespace

PosedSet ReadGaussianSplattingSet(const fs::path& file, const fs::path& chosen) {
  json document = json::object();
  document["cameras"] = ParseJson(ReadWholeFile(file), file.string(), "train again, or copy it again");
  PosedSet set;
  set.format = "gaussian-splatting";
  LightField& light_field = set.light_field;
  const std::vector<JsonPlace> cameras = EntriesOf(JsonPlace{document, file.string()}, "cameras");
  if (cameras.empty()) throw Error("{}: lists no camera; train again, or copy it again", file.string());
  std::vector<std::string> names;
  for (const JsonPlace& camera : cameras) names.push_back(camera.Text("img_name"));
  const fs::path base = fs::absolute(file).lexically_normal().parent_path();
  std::vector<fs::path> folders = FoldersOfNames(base, names);
  if (const auto of_training = FolderOfTraining(base)) folders.insert(folders.begin(), *of_training);
  SetImages images(base, chosen, folders);
  images.Reserve(names);

  NamedViews named(file, images, set);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string where = fmt::format("{} ({})", cameras[i].where, names[i]);
    const std::string path = named.Find(names[i], where);
    if (path.empty()) continue;
    CameraModel camera = CameraModel::Pinhole(cameras[i].Integer("width"), cameras[i].Integer("height"),
                                              cameras[i].Positive("fx"));
    camera.fy = cameras[i].Positive("fy");
    named.Add(path, camera, TrainedPose(cameras[i]), where);
  }
  named.RequireFound();
  ReadPointPositions(base / "input.ply", light_field);
  return set;
}

}  // namespace ulf
