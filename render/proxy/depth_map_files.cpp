#include "render/proxy/depth_map_files.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geometry/camera_json.h"
#include "core/geometry/digest.h"

namespace ulf::render {
namespace {

namespace fs = std::filesystem;

constexpr char kIndex[] = "maps.json";
constexpr char kFormat[] = "ulf depth maps 1";

// Of the pose and the camera under which the map was made.
std::string DigestOf(const LightField& light_field, const View& view) {
  Digest digest;
  digest.Add(view.cam_from_world);
  digest.Add(light_field.CameraOf(view));
  return fmt::format("{:016x}", digest.Value());
}

struct MapFile {
  fs::path path;
  std::string checksum;
  CameraModel camera;
  double unit, step;
};

ViewDepthMap ReadMap(const MapFile& file) {
  const std::string bytes = ReadWholeFile(file.path);
  if (fmt::format("{:016x}", FastChecksumOf(bytes)) != file.checksum)
    throw Error("{}: its bytes have changed", file.path.string());
  const cv::Mat pixels =
      cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data())),
                   cv::IMREAD_UNCHANGED);
  if (pixels.type() != CV_16UC1 || pixels.cols != file.camera.width || pixels.rows != file.camera.height)
    throw Error("{}: no depth map of {}x{}", file.path.string(), file.camera.width, file.camera.height);
  return {file.camera, pixels, file.unit, file.step};
}

// A view's map as far as the file can be read, else the mesh as the view sees it.
std::shared_ptr<const LazyDepthMap> MapFrom(const MapFile& file, const Rigid3& cam_from_world,
                                            const std::shared_ptr<const TriangleMesh>& mesh) {
  return std::make_shared<LazyDepthMap>([file, cam_from_world, mesh] {
    try {
      return ReadMap(file);
    } catch (const Error& error) {
      spdlog::warn("{}; the mesh stands in for this depth map (ulf proxy makes it again)", error.what());
      return DepthMapOfMesh(*mesh, file.camera, cam_from_world, file.step);
    }
  });
}

std::string PngOf(const ViewDepthMap& map) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", map.inverse_depth, bytes)) throw Error("a depth map cannot be written as PNG");
  return {bytes.begin(), bytes.end()};
}

void RemoveOthers(const fs::path& folder, const std::set<std::string>& kept) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (!kept.contains(entry.path().filename().string())) fs::remove(entry.path(), ignored);
}

}  // namespace

void WriteDepthMaps(const fs::path& light_field_folder, const LightField& light_field,
                    const std::map<int, ViewDepthMap>& maps) {
  const fs::path folder = light_field_folder / kDepthMapsFolder;
  MakeFolder(folder);
  nlohmann::json entries = nlohmann::json::array();
  std::set<std::string> kept{kIndex};
  for (const auto& [id, map] : maps) {
    const auto view = std::ranges::find(light_field.views, id, &View::id);
    if (view == light_field.views.end()) throw Error("{}: there is no view {}", folder.string(), id);
    const std::string png = PngOf(map), checksum = fmt::format("{:016x}", FastChecksumOf(png));
    // The name says which bytes: a map that is there is never overwritten by another one.
    const std::string name = fmt::format("{:06}-{}.png", id, checksum.substr(0, 8));
    WriteFileAtomically(folder / name, png);
    kept.insert(name);
    entries.push_back({{"view", id},
                       {"file", name},
                       {"checksum", checksum},
                       {"made_under", DigestOf(light_field, *view)},
                       {"camera", CameraToJson(map.camera)},
                       {"unit", map.unit},
                       {"step", map.step}});
  }
  WriteFileAtomically(folder / kIndex, nlohmann::json{{"format", kFormat}, {"maps", entries}}.dump(1) + "\n");
  RemoveOthers(folder, kept);
}

bool HasDepthMaps(const fs::path& light_field_folder) {
  return fs::exists(light_field_folder / kDepthMapsFolder / kIndex);
}

DepthMapReading ReadDepthMaps(const fs::path& light_field_folder, const LightField& light_field,
                              std::shared_ptr<const TriangleMesh> mesh) {
  const fs::path folder = light_field_folder / kDepthMapsFolder, index = folder / kIndex;
  const nlohmann::json json = nlohmann::json::parse(ReadWholeFile(index), nullptr, false);
  if (!json.is_object() || json.value("format", "") != kFormat || !json.contains("maps") ||
      !json["maps"].is_array())
    throw Error("{}: this is no index of depth maps, or it was cut short", index.string());
  DepthMapReading reading;
  for (const nlohmann::json& entry : json["maps"]) {
    const JsonPlace place{entry, index.string()};
    const int id = place.Integer("view");
    const auto view = std::ranges::find(light_field.views, id, &View::id);
    if (view == light_field.views.end() || DigestOf(light_field, *view) != place.Text("made_under")) {
      ++reading.stale;
      continue;
    }
    const fs::path name = place.Text("file");
    if (name.filename() != name)
      throw Error("{}: view {}: the file {} lies elsewhere", index.string(), id, name.string());
    const MapFile file{folder / name, place.Text("checksum"),
                       CameraFromJson({place.Raw("camera"), fmt::format("{}, view {}", index.string(), id)}),
                       place.Positive("unit"), place.Positive("step")};
    if (file.camera.distortion != Distortion::kNone)
      throw Error("{}: view {}: a depth map's camera has no distortion", index.string(), id);
    reading.maps.emplace(id, MapFrom(file, view->cam_from_world, mesh));
  }
  return reading;
}

}  // namespace ulf::render
