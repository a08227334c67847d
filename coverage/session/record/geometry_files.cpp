#include "coverage/session/record/geometry_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "core/base/counted.h"
#include "core/geometry/angles.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/depth_raster.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"

namespace ulf::coverage {
namespace {

namespace fs = std::filesystem;
using Say = std::function<void(const std::string&)>;

std::string Replaced(const std::optional<render::GeometryState>& before, const fs::path& kept,
                     const std::optional<fs::path>& kept_maps, const FinishedGeometry& now,
                     const std::string& proxy_command) {
  const std::size_t triangles_before = before ? before->triangles : 0;
  return fmt::format(
      "views were added: a new mesh of {}, made of small pictures, takes the place of the one that was "
      "there{}, which is kept: {}{}; '{}' makes a fine one of all views",
      Counted(now.mesh->mesh->triangles.size(), "triangle"),
      triangles_before > 0 ? fmt::format(" ({})", Counted(triangles_before, "triangle")) : "", kept.string(),
      kept_maps ? fmt::format(", with its depth maps: {}", kept_maps->string()) : "", proxy_command);
}

// Returns the views as they were when the mesh was made: those whose maps were taken out of `maps_then` to
// make `maps`, because they were recorded with another pose, have the pose of the map.
LightField AsWhenMeshed(LightField light_field, const FinishedGeometry& finished,
                        const std::set<int>& maps_then, const std::map<int, render::ViewDepthMap>& maps) {
  for (View& view : light_field.views)
    if (maps_then.contains(view.id) && !maps.contains(view.id))
      if (const auto then = finished.map_poses.find(view.id); then != finished.map_poses.end())
        view.cam_from_world = then->second;
  return light_field;
}

// Returns how many views the mesh was made without: they could not be read, or there was no time to look at
// them or for their maps.
std::size_t ViewsLeftOut(const LightField& light_field, const FinishedGeometry& finished) {
  const auto left_out = std::ranges::count_if(light_field.views, [&](const View& view) {
    return finished.views_left_out.contains(view.id) || finished.unreadable_views.contains(view.id);
  });
  return static_cast<std::size_t>(left_out) + static_cast<std::size_t>(finished.missing_maps);
}

// The mesh and the depth maps that are there. Throws Error.
struct ExistingGeometry {
  std::shared_ptr<const render::TriangleMesh> mesh;
  render::DepthMapReading maps;
};
ExistingGeometry ReadExistingGeometry(const LightField& light_field) {
  ExistingGeometry there{std::make_shared<const render::TriangleMesh>(
                             render::ReadMeshFile(light_field.root / render::kMeshProxyFile).mesh),
                         {}};
  if (render::HasDepthMaps(light_field.root))
    there.maps = render::ReadDepthMaps(light_field.root, light_field, there.mesh);
  return there;
}

int LongerSide(const CameraModel& camera) { return std::max(camera.width, camera.height); }

// Returns where a view stands, as seen from the subject; a direction along its axis where there is none.
Eigen::Vector3d SeenFromSubject(const LightField& light_field, const View& view) {
  return light_field.subject ? (view.CenterInWorld() - light_field.subject->center_in_world).normalized()
                             : view.cam_from_world.DirectionInSource(-Eigen::Vector3d::UnitZ());
}

// Returns how many of the views that have a map in `before` have none in `now` near them.
std::size_t WithoutMapNear(const LightField& light_field, const render::SoftProxy::Maps& before,
                           const std::map<int, render::ViewDepthMap>& now) {
  // A capture's own maps stand that far apart where there are many.
  const double near = 3 * render::GrowingGeometryOptions{}.least_apart;
  std::vector<Eigen::Vector3d> directions;
  for (const View& view : light_field.views)
    if (now.contains(view.id)) directions.push_back(SeenFromSubject(light_field, view));
  return static_cast<std::size_t>(std::ranges::count_if(light_field.views, [&](const View& view) {
    if (!before.contains(view.id) || now.contains(view.id)) return false;
    const Eigen::Vector3d direction = SeenFromSubject(light_field, view);
    return std::ranges::none_of(directions,
                                [&](const auto& other) { return AngleBetween(direction, other) <= near; });
  }));
}

}  // namespace

std::vector<KnownMap> ReadKnownMaps(const LightField& light_field) {
  std::vector<KnownMap> known;
  try {
    if (!render::HasDepthMaps(light_field.root)) return known;
    const ExistingGeometry there = ReadExistingGeometry(light_field);
    for (const View& view : light_field.views) {
      const auto found = there.maps.maps.find(view.id);
      if (found == there.maps.maps.end()) continue;
      const render::ViewDepthMap& map = found->second->Get();
      KnownMap& made = known.emplace_back(KnownMap{view.id, map.camera, {}, map.step});
      const cv::Mat of_mesh = render::DrawInverseDepth(*there.mesh, map.camera, view.cam_from_world);
      made.depth = cv::Mat::zeros(of_mesh.size(), CV_32F);
      for (int y = 0; y < made.depth.rows; ++y)
        for (int x = 0; x < made.depth.cols; ++x)
          if (const double inverse = map.InverseDepthAt(x, y); inverse > 0 && of_mesh.at<float>(y, x) > 0)
            made.depth.at<float>(y, x) = static_cast<float>(1 / inverse);
    }
  } catch (const std::exception&) {
    known.clear();  // they are made anew
  }
  return known;
}

std::string WhyExistingIsBetter(const fs::path& root, const FinishedGeometry& finished) {
  LightField light_field;
  ExistingGeometry there;
  try {
    if (!fs::exists(root / render::kMeshProxyFile)) return {};
    light_field = ReadLightField(root);
    there = ReadExistingGeometry(light_field);
  } catch (const std::exception&) {
    return {};
  }
  const auto& before = there.maps.maps;
  const auto& now = finished.maps_for_rendering;
  if (before.empty()) {
    // Its triangles are all that is known of it. Meshes of the same maps differ by a few.
    constexpr double kAsFine = 0.9;
    const auto triangles = static_cast<double>(there.mesh->triangles.size());
    if (there.maps.stale > 0 ||
        static_cast<double>(finished.mesh->mesh->triangles.size()) >= kAsFine * triangles)
      return {};
    return fmt::format("{}, and a new one would have {}", Counted(there.mesh->triangles.size(), "triangle"),
                       finished.mesh->mesh->triangles.size());
  }
  int side_before = 0, side_now = 0;
  for (const auto& [id, map] : before) side_before = std::max(side_before, LongerSide(map->Get().camera));
  for (const auto& [id, map] : now) side_now = std::max(side_now, LongerSide(map.camera));
  const std::size_t lost = WithoutMapNear(light_field, before, now);
  if (side_now >= side_before && now.size() >= before.size() && lost == 0) return {};
  std::string why = fmt::format("{} of {} px, and a new one would have {} of {} px",
                                Counted(before.size(), "depth map"), side_before, now.size(), side_now);
  if (lost > 0) why += fmt::format(", none of them near {} that had one", Counted(lost, "view"));
  return why;
}

void WriteGeometry(const fs::path& root, FinishedGeometry& finished, const Say& say) {
  const std::string command = render::ProxyCommand(root);
  try {
    // It is read as renderers read it, because mesh and maps are bound to these poses.
    const LightField light_field = ReadLightField(root);
    const std::optional<render::GeometryState> before = render::GeometryStateOf(light_field);
    std::set<int> maps_then;
    for (const auto& [id, map] : finished.maps_for_rendering) maps_then.insert(id);
    const std::size_t moved =
        render::TakeOutMovedMaps(light_field, finished.map_poses, finished.maps_for_rendering);
    const auto maps = std::exchange(finished.maps_for_rendering, {});
    const std::string ply = render::MeshPlyBytes(
        *finished.mesh->mesh,
        render::OriginComments("ulf capture", AsWhenMeshed(light_field, finished, maps_then, maps),
                               ViewsLeftOut(light_field, finished)));
    render::KeptGeometry kept;
    try {
      kept = render::WriteGeometryFiles(light_field, ply, maps, render::FormerGeometry::kKept);
      finished.written_maps = static_cast<int>(maps.size());
    } catch (const std::exception& error) {
      if (before) throw;  // the geometry that is there stays, whole
      kept = render::WriteGeometryFiles(light_field, ply, {}, render::FormerGeometry::kKept);
      say(fmt::format("{}; the light field and its mesh are complete, without depth maps, which '{}' makes",
                      error.what(), command));
    }
    if (moved > 0)
      say(fmt::format(
          "geometry: {} made under other poses than the recorded ones and left out; '{}' makes them",
          moved == 1 ? "one depth map was" : fmt::format("{} depth maps were", moved), command));
    if (kept.mesh)
      say(Replaced(before, *kept.mesh, kept.maps, finished, command));
    else if (kept.maps)
      say(fmt::format("geometry: depth maps without a mesh were there; they are kept as {}",
                      kept.maps->string()));
  } catch (const std::exception& error) {
    say(fmt::format("{}; no new mesh was written, and a mesh that was there stays; '{}' makes one",
                    error.what(), command));
    finished.mesh = nullptr;
    finished.maps_for_rendering.clear();
  }
}

}  // namespace ulf::coverage
