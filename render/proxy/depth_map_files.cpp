#include "render/proxy/depth_map_files.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/camera_json.h"
#include "core/geometry/digest.h"
#include "core/image/files/image_header.h"
#include "core/image/files/png_picture.h"
#include "core/image/image.h"
#include "core/light_field/folder/opened_folder.h"
#include "render/proxy/mesh_file.h"

namespace ulf::render {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr char kIndex[] = "maps.json";
constexpr char kFormat[] = "ulf depth maps 1";

// Digests the pose and the camera under which the map was made.
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
  // Checks by the header, before a decoder allocates what it claims.
  const auto header = ReadImageHeader(file.path.string());
  if (!header || header->kind != "PNG" || header->bits != 16 || header->channels != 1 ||
      header->width != file.camera.width || header->height != file.camera.height)
    throw Error("{}: no depth map of {}x{}", file.path.string(), file.camera.width, file.camera.height);
  const cv::Mat pixels = ReadPng(bytes, file.path.string()).pixels;
  if (pixels.type() != CV_16UC1) throw Error("{}: cannot be decoded", file.path.string());
  return {file.camera, pixels, file.unit, file.step};
}

// Returns a view's map if the file can be read, or else the mesh as the view sees it.
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

// Removes remains of former maps; other programs may keep files of their own in a folder of this name.
void RemoveFormerMaps(const fs::path& folder, const std::set<std::string>& kept) {
  static const std::string kMap = "[0-9]{6,}-[0-9a-f]{8}\\.png";
  static const std::regex kOurs(kMap);
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (kept.contains(name)) continue;
    if (std::regex_match(name, kOurs)) fs::remove(entry.path(), ignored);
  }
}

std::string MeshChecksum(const fs::path& light_field_folder) {
  const fs::path mesh = light_field_folder / kMeshProxyFile;
  return fs::exists(mesh) ? ChecksumForIndex(ReadWholeFile(mesh)) : std::string();
}

json IndexIn(const fs::path& folder) {
  return fs::exists(folder / kIndex) ? JsonOrDiscarded(ReadWholeFile(folder / kIndex)) : json();
}

bool IsIndex(const json& index) {
  return index.is_object() && index.value("format", json()) == kFormat && index.contains("maps") &&
         index["maps"].is_array();
}

bool IsBeingReplaced(const json& index) {
  return IsIndex(index) && index.contains("next") && index["next"].is_object() &&
         index["next"].contains("maps") && index["next"]["maps"].is_array();
}

// Returns the mesh and the maps of the index, or those that replace them if the mesh of this checksum is
// theirs.
json SetOf(const json& index, const std::string& mesh) {
  const bool is_next = IsBeingReplaced(index) && index["next"].value("mesh", json()) == mesh;
  const json& set = is_next ? index["next"] : index;
  return {{"mesh", set.value("mesh", json())}, {"maps", set["maps"]}};
}

// Returns the valid file names of the maps.
std::set<std::string> NamesIn(const json& maps) {
  std::set<std::string> names;
  for (const json& entry : maps) {
    if (!entry.is_object() || !entry.contains("file") || !entry["file"].is_string()) continue;
    const fs::path name = entry["file"].get<std::string>();
    if (name.filename() == name) names.insert(name.string());
  }
  return names;
}

void WriteIndex(const fs::path& folder, json set) {
  set["format"] = kFormat;
  WriteFileAtomically(folder / kIndex, JsonText(set, 1) + "\n");
}

// Returns an unused name in kept/, relative to the light field's folder.
std::string FreeNameInKept(const fs::path& root, const fs::path& wanted) {
  fs::path name = fs::path("kept") / wanted;
  for (int number = 2; fs::exists(fs::symlink_status(root / name)); ++number)
    name = fs::path("kept") /
           fmt::format("{}-{}{}", wanted.stem().string(), number, wanted.extension().string());
  return name.generic_string();
}

// Returns the path that the index names in kept/; empty if it names none, or one that leads elsewhere.
fs::path KeptPath(const json& next, const char* key) {
  if (!next.contains(key) || !next[key].is_string()) return {};
  const fs::path path = next[key].get<std::string>();
  return path.parent_path() == "kept" && path == path.lexically_normal() ? path : fs::path();
}

bool IsSameFile(const fs::path& a, const fs::path& b) {
  std::error_code unknown;
  return fs::equivalent(a, b, unknown) && !unknown;
}

// Moves the maps of `set` to `kept`, with an index of their own; those of `staying` are in both folders.
void MoveMapsToKept(const fs::path& folder, const fs::path& kept, const json& set,
                    const std::set<std::string>& staying) {
  MakeFolder(kept);
  for (const std::string& name : NamesIn(set["maps"])) {
    if (!fs::is_regular_file(folder / name)) continue;
    if (staying.contains(name))
      LinkOrCopy(folder / name, kept / name);
    else
      MoveWithoutReplacing(folder / name, kept / name);
  }
  WriteIndex(kept, set);
}

// Writes the maps' files, and returns their entries in the index.
json WriteMapFiles(const fs::path& folder, const LightField& light_field,
                   const std::map<int, ViewDepthMap>& maps, std::deque<FileBatch>& batches) {
  json entries = json::array();
  // One wait for the disk serves a batch of files, whose number is bounded because they are open until then.
  constexpr std::size_t kFilesAtOnce = 64;
  for (const auto& [id, map] : maps) {
    const auto view = std::ranges::find(light_field.views, id, &View::id);
    if (view == light_field.views.end()) throw Error("{}: there is no view {}", folder.string(), id);
    const std::string png = PngBytes(map.inverse_depth), checksum = ChecksumForIndex(png);
    // The name contains the checksum: an existing map is never overwritten by another one.
    const std::string name = fmt::format("{:06}-{}.png", id, checksum.substr(0, 8));
    if (entries.size() % kFilesAtOnce == 0) {
      if (!batches.empty()) batches.back().Commit();
      batches.emplace_back();
    }
    batches.back().Write(folder / name, ContentOf(png));
    entries.push_back({{"view", id},
                       {"file", name},
                       {"checksum", checksum},
                       {"made_under", DigestOf(light_field, *view)},
                       {"camera", CameraToJson(map.camera)},
                       {"unit", map.unit},
                       {"step", map.step}});
  }
  if (!batches.empty()) batches.back().Commit();
  return entries;
}

// Replaces the mesh, and keeps the former one as `kept`. Throws Error; the mesh is then unchanged.
void ReplaceMesh(const fs::path& root, const std::string& mesh_ply, const fs::path& kept) {
  const fs::path mesh = root / kMeshProxyFile;
  try {
    if (!kept.empty()) {
      MakeFolderIn(root, "kept");
      LinkOrCopy(mesh, root / kept);
    }
    WriteFileAtomically(mesh, mesh_ply);
  } catch (...) {
    std::error_code stays;
    if (!kept.empty()) fs::remove(root / kept, stays);
    throw;
  }
}

}  // namespace

std::size_t TakeOutMovedMaps(const LightField& light_field, const std::map<int, Rigid3>& made_under,
                             std::map<int, ViewDepthMap>& maps) {
  // A map of 320 pixels is this exact at best. Guessed.
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

void FinishGeometryFiles(const fs::path& light_field_folder) {
  const fs::path folder = light_field_folder / kDepthMapsFolder;
  const json index = IndexIn(folder);
  if (!IsBeingReplaced(index)) {
    // These are maps that a killed writer did not list.
    if (index.is_null() || IsIndex(index))
      RemoveFormerMaps(folder, index.is_null() ? std::set<std::string>() : NamesIn(index["maps"]));
    return;
  }
  const std::string mesh = MeshChecksum(light_field_folder);
  const json set = SetOf(index, mesh);
  const std::set<std::string> names = NamesIn(set["maps"]);
  const bool is_replaced = set["mesh"] == index["next"].value("mesh", json());
  const fs::path kept_maps = KeptPath(index["next"], "kept_maps"),
                 kept_mesh = KeptPath(index["next"], "kept_mesh");
  if (is_replaced && !kept_maps.empty())
    MoveMapsToKept(folder, light_field_folder / kept_maps, {{"mesh", index["mesh"]}, {"maps", index["maps"]}},
                   names);
  std::error_code stays;
  if (!is_replaced && !kept_mesh.empty() &&
      IsSameFile(light_field_folder / kept_mesh, light_field_folder / kMeshProxyFile))
    fs::remove(light_field_folder / kept_mesh, stays);
  if (names.empty())
    fs::remove(folder / kIndex);
  else
    WriteIndex(folder, set);
  RemoveFormerMaps(folder, names);
  fs::remove(folder, stays);  // fails with maps, or files of other programs in it
}

KeptGeometry WriteGeometryFiles(const LightField& light_field, const std::string& mesh_ply,
                                const std::map<int, ViewDepthMap>& maps, FormerGeometry former) {
  const fs::path& root = light_field.root;
  const fs::path folder = root / kDepthMapsFolder;
  FinishGeometryFiles(root);
  const json index = IndexIn(folder);
  const bool keeps = former == FormerGeometry::kKept, had_index = IsIndex(index);
  const fs::path kept_mesh =
      keeps && fs::exists(root / kMeshProxyFile) ? FreeNameInKept(root, kMeshProxyFile) : "";
  const fs::path kept_maps =
      keeps && had_index && !index["maps"].empty() ? FreeNameInKept(root, kDepthMapsFolder) : "";
  KeptGeometry kept;
  if (!kept_mesh.empty()) kept.mesh = root / kept_mesh;
  if (!kept_maps.empty()) kept.maps = root / kept_maps;
  if (maps.empty() && !fs::exists(folder / kIndex)) {
    ReplaceMesh(root, mesh_ply, kept_mesh);
    return kept;
  }
  const bool is_new = !fs::exists(folder);
  MakeFolderIn(root, kDepthMapsFolder);
  std::deque<FileBatch> batches;
  json both{{"mesh", MeshChecksum(root)}, {"maps", json::array()}};
  if (had_index) both = SetOf(index, MeshChecksum(root));
  const json before = both;
  try {
    both["next"] = {{"mesh", ChecksumForIndex(mesh_ply)},
                    {"maps", WriteMapFiles(folder, light_field, maps, batches)}};
    if (!kept_mesh.empty()) both["next"]["kept_mesh"] = kept_mesh.generic_string();
    if (!kept_maps.empty()) both["next"]["kept_maps"] = kept_maps.generic_string();
    WriteIndex(folder, both);
    ReplaceMesh(root, mesh_ply, kept_mesh);
  } catch (...) {
    for (FileBatch& batch : batches) batch.TakeBack();
    std::error_code stays;  // fails with files of other programs in it
    try {
      if (had_index) WriteIndex(folder, before);
    } catch (const Error&) {
      // The index lists both meshes; the former one counts.
    }
    if (!had_index) fs::remove(folder / kIndex, stays);
    if (is_new) fs::remove(folder, stays);
    throw;
  }
  try {
    FinishGeometryFiles(root);
  } catch (const Error& error) {
    spdlog::warn("{}; mesh and depth maps are complete, and the next 'ulf proxy' tidies up", error.what());
  }
  return kept;
}

bool HasDepthMaps(const fs::path& light_field_folder) {
  const fs::path folder = light_field_folder / kDepthMapsFolder;
  if (!fs::exists(folder / kIndex)) return false;
  const json index = IndexIn(folder);
  return !IsBeingReplaced(index) || !SetOf(index, MeshChecksum(light_field_folder))["maps"].empty();
}

DepthMapReading ReadDepthMaps(const fs::path& light_field_folder, const LightField& light_field,
                              std::shared_ptr<const TriangleMesh> mesh) {
  const fs::path folder = light_field_folder / kDepthMapsFolder, index = folder / kIndex;
  const json content = JsonOrDiscarded(ReadWholeFile(index));
  if (!IsIndex(content))
    throw Error("{}: this is no index of depth maps, or it was cut short", index.string());
  const std::string mesh_checksum = MeshChecksum(light_field_folder);
  const json set = SetOf(content, mesh_checksum);
  if (set["mesh"] != mesh_checksum)
    throw Error("{}: these depth maps were made beside another mesh than {}", folder.string(),
                kMeshProxyFile);
  DepthMapReading reading;
  for (const json& entry : set["maps"]) {
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

std::string ChecksumForIndex(std::string_view bytes) { return ChecksumText(FastChecksumOf(bytes)); }

std::string ReadIndexedFile(const std::filesystem::path& path, const std::string& checksum) {
  std::string bytes = ReadWholeFile(path);
  if (ChecksumForIndex(bytes) != checksum) throw Error("{}: its bytes have changed", path.string());
  return bytes;
}

}  // namespace ulf::render
