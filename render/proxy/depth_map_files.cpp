#include "render/proxy/depth_map_files.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/camera_json.h"
#include "core/geometry/digest.h"
#include "core/image/image.h"
#include "core/image/image_header.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/indexed_file.h"
#include "render/proxy/proxy_choice.h"

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
  return ChecksumText(digest.Value());
}

struct MapFile {
  fs::path path;
  std::string checksum;
  CameraModel camera;
  double unit, step;
};

ViewDepthMap ReadMap(const MapFile& file) {
  std::string bytes = ReadIndexedFile(file.path, file.checksum);
  // By the header, before a decoder makes room for what it claims.
  const auto header = ReadImageHeader(file.path.string());
  if (!header || header->kind != "PNG" || header->bits != 16 || header->channels != 1 ||
      header->width != file.camera.width || header->height != file.camera.height)
    throw Error("{}: no depth map of {}x{}", file.path.string(), file.camera.width, file.camera.height);
  cv::Mat pixels;
  try {
    pixels =
        cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, bytes.data()), cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
  }
  if (pixels.type() != CV_16UC1) throw Error("{}: cannot be decoded", file.path.string());
  return {file.camera, pixels, file.unit, file.step};
}

// A view's map as far as the file can be read, else the mesh as the view sees it.
std::shared_ptr<const LazyDepthMap> MapFrom(const MapFile& file, const Rigid3& cam_from_world,
                                            const std::shared_ptr<const TriangleMesh>& mesh) {
  return std::make_shared<LazyDepthMap>([file, cam_from_world, mesh] {
    try {
      return ReadMap(file);
    } catch (const Error& error) {
      spdlog::warn("{}; the mesh stands in for this depth map ('{}' makes it again)", error.what(),
                   ProxyCommand(file.path.parent_path().parent_path()));
      return DepthMapOfMesh(*mesh, file.camera, cam_from_world, file.step);
    }
  });
}

// Remains of former maps; other programs may keep files of their own in a folder of this name.
void RemoveFormerMaps(const fs::path& folder, const std::set<std::string>& kept) {
  static const std::string kMap = "[0-9]{6,}-[0-9a-f]{8}\\.png";
  static const std::regex kOurs(kMap), kOurTemporaries("(" + kMap + "|maps\\.json)\\.[0-9]+-[0-9]+\\.part");
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (kept.contains(name)) continue;
    if (std::regex_match(name, kOurs) || (std::regex_match(name, kOurTemporaries) && IsLeftTemporary(entry)))
      fs::remove(entry.path(), ignored);
  }
}

std::string MeshChecksum(const fs::path& light_field_folder) {
  const fs::path mesh = light_field_folder / kMeshProxyFile;
  return fs::exists(mesh) ? ChecksumForIndex(ReadWholeFile(mesh)) : std::string();
}

// The files that an index names, itself the last.
std::vector<std::string> FilesOf(const fs::path& folder) {
  std::vector<std::string> names;
  const nlohmann::json json = JsonOrDiscarded(ReadWholeFile(folder / kIndex));
  if (json.is_object() && json.contains("maps") && json["maps"].is_array())
    for (const nlohmann::json& entry : json["maps"]) {
      if (!entry.is_object() || !entry.contains("file") || !entry["file"].is_string()) continue;
      const fs::path name = entry["file"].get<std::string>();
      if (name.filename() == name && fs::is_regular_file(folder / name)) names.push_back(name.string());
    }
  names.emplace_back(kIndex);
  return names;
}

fs::path MakeFreeFolder(const fs::path& folder) {
  MakeFolder(FolderOf(folder));
  fs::path name = folder;
  for (int number = 2; !fs::create_directory(name); ++number)
    name = fmt::format("{}-{}", folder.string(), number);
  return name;
}

}  // namespace

std::size_t TakeOutMovedMaps(const LightField& light_field, const std::map<int, Rigid3>& made_under,
                             std::map<int, ViewDepthMap>& maps) {
  // A map of 320 pixels is that exact where it is at its best. Guessed.
  constexpr double kMost_px = 0.1;
  std::size_t moved = 0;
  std::erase_if(maps, [&](const auto& id_and_map) {
    const auto& [id, map] = id_and_map;
    const auto view = std::ranges::find(light_field.views, id, &View::id);
    if (view == light_field.views.end()) return true;
    const auto then = made_under.find(id);
    const double distance =
        light_field.subject ? (view->cam_from_world * light_field.subject->center_in_world).norm() : 1;
    const bool has_moved = then == made_under.end() ||
                           !(MovedPx(map.camera, then->second, view->cam_from_world, distance) <= kMost_px);
    moved += has_moved;
    return has_moved;
  });
  return moved;
}

std::optional<fs::path> MoveDepthMapsToKept(const fs::path& light_field_folder) {
  if (!HasDepthMaps(light_field_folder)) return std::nullopt;
  const fs::path folder = light_field_folder / kDepthMapsFolder;
  const std::vector<std::string> names = FilesOf(folder);
  const fs::path kept = MakeFreeFolder(light_field_folder / "kept" / kDepthMapsFolder);
  for (const std::string& name : names) MoveWithoutReplacing(folder / name, kept / name);
  SyncFolder(kept);
  std::error_code stays;  // with files of other programs
  fs::remove(folder, stays);
  return kept;
}

void WriteDepthMaps(const fs::path& light_field_folder, const LightField& light_field,
                    const std::map<int, ViewDepthMap>& maps) {
  const fs::path folder = light_field_folder / kDepthMapsFolder;
  const bool is_new = !fs::exists(folder);
  MakeFolder(folder);
  nlohmann::json entries = nlohmann::json::array();
  std::set<std::string> kept{kIndex};
  // One wait for the disk serves a batch of files, whose number is bounded because they are open until then.
  constexpr std::size_t kFilesAtOnce = 64;
  std::deque<FileBatch> batches;
  try {
    for (const auto& [id, map] : maps) {
      const auto view = std::ranges::find(light_field.views, id, &View::id);
      if (view == light_field.views.end()) throw Error("{}: there is no view {}", folder.string(), id);
      const std::string png = PngBytes(map.inverse_depth), checksum = ChecksumForIndex(png);
      // The name says which bytes: a map that is there is never overwritten by another one.
      const std::string name = fmt::format("{:06}-{}.png", id, checksum.substr(0, 8));
      if (entries.size() % kFilesAtOnce == 0) {
        if (!batches.empty()) batches.back().Commit();
        batches.emplace_back();
      }
      batches.back().Write(folder / name, ContentOf(png));
      kept.insert(name);
      entries.push_back({{"view", id},
                         {"file", name},
                         {"checksum", checksum},
                         {"made_under", DigestOf(light_field, *view)},
                         {"camera", CameraToJson(map.camera)},
                         {"unit", map.unit},
                         {"step", map.step}});
    }
    if (!batches.empty()) batches.back().Commit();
    WriteFileAtomically(folder / kIndex, JsonText(nlohmann::json{{"format", kFormat},
                                                                 {"mesh", MeshChecksum(light_field_folder)},
                                                                 {"maps", entries}},
                                                  1) +
                                             "\n");
  } catch (...) {
    // The new index is not there: WriteFileAtomically throws nothing after its rename.
    for (FileBatch& batch : batches) batch.TakeBack();
    std::error_code stays;  // with files of other programs
    if (is_new) fs::remove(folder, stays);
    throw;
  }
  RemoveFormerMaps(folder, kept);
}

bool HasDepthMaps(const fs::path& light_field_folder) {
  return fs::exists(light_field_folder / kDepthMapsFolder / kIndex);
}

DepthMapReading ReadDepthMaps(const fs::path& light_field_folder, const LightField& light_field,
                              std::shared_ptr<const TriangleMesh> mesh) {
  const fs::path folder = light_field_folder / kDepthMapsFolder, index = folder / kIndex;
  const nlohmann::json json = JsonOrDiscarded(ReadWholeFile(index));
  if (!json.is_object() || json.value("format", nlohmann::json()) != kFormat || !json.contains("maps") ||
      !json["maps"].is_array())
    throw Error("{}: this is no index of depth maps, or it was cut short", index.string());
  if (json.value("mesh", nlohmann::json()) != MeshChecksum(light_field_folder))
    throw Error("{}: these depth maps were made beside another mesh than {}", folder.string(),
                kMeshProxyFile);
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
    const CameraModel& of_view = light_field.CameraOf(*view);
    if (file.camera.width > of_view.width || file.camera.height > of_view.height)
      throw Error("{}: view {}: a depth map of {}x{} is larger than the photograph", index.string(), id,
                  file.camera.width, file.camera.height);
    if (file.camera.distortion != Distortion::kNone)
      throw Error("{}: view {}: a depth map's camera has no distortion", index.string(), id);
    reading.digest = FastChecksumOf(file.checksum, reading.digest);
    reading.maps.emplace(id, MapFrom(file, view->cam_from_world, mesh));
  }
  return reading;
}

}  // namespace ulf::render
