#include "coverage/session/record/geometry_files.h"

#include <fmt/format.h>

#include <exception>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/base/counted.h"
#include "core/light_field/light_field_io.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/proxy_choice.h"

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
      "there{}, "
      "which is kept: {}{}; '{}' makes a fine one of all views",
      Counted(now.mesh->mesh->triangles.size(), "triangle"),
      triangles_before > 0 ? fmt::format(" ({})", Counted(triangles_before, "triangle")) : "", kept.string(),
      kept_maps ? fmt::format(", with its depth maps: {}", kept_maps->string()) : "", proxy_command);
}

// The views of which the mesh was made, as they were then: without those that could not be read or for which there was no
// time, and of those whose maps were taken out of `maps_then` to make `maps`, because they were recorded with another pose, the pose of the map.
LightField MadeOf(LightField light_field, const FinishedGeometry& finished, const std::set<int>& maps_then,
                  const std::map<int, render::ViewDepthMap>& maps) {
  std::erase_if(light_field.views, [&](const View& view) {
    return finished.views_left_out.contains(view.id) || finished.unreadable_views.contains(view.id) ||
           (finished.missing_maps > 0 && !finished.map_poses.contains(view.id));
  });
  for (View& view : light_field.views)
    if (maps_then.contains(view.id) && !maps.contains(view.id))
      if (const auto then = finished.map_poses.find(view.id); then != finished.map_poses.end())
        view.cam_from_world = then->second;
  return light_field;
}

}  // namespace

void WriteGeometry(const fs::path& root, FinishedGeometry& finished, const Say& say) {
  const std::string command = render::ProxyCommand(root);
  try {
    // As whoever renders reads it: mesh and maps are bound to these poses.
    const LightField light_field = ReadLightField(root);
    const std::optional<render::GeometryState> before = render::GeometryStateOf(light_field);
    std::set<int> maps_then;
    for (const auto& [id, map] : finished.maps_for_rendering) maps_then.insert(id);
    const std::size_t moved =
        render::TakeOutMovedMaps(light_field, finished.map_poses, finished.maps_for_rendering);
    const auto maps = std::exchange(finished.maps_for_rendering, {});
    const render::KeptGeometry kept = render::WriteGeometryFiles(
        light_field,
        render::MeshPlyBytes(
            *finished.mesh->mesh,
            render::OriginComments("ulf capture", MadeOf(light_field, finished, maps_then, maps))),
        maps, render::FormerGeometry::kKept);
    finished.written_maps = static_cast<int>(maps.size());
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
    say(
        fmt::format("{}; the light field is complete, with the geometry that it had before; '{}' makes a new "
                    "one",
                    error.what(), command));
    finished.mesh = nullptr;
    finished.maps_for_rendering.clear();
  }
}

}  // namespace ulf::coverage
