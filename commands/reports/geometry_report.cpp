#include "commands/reports/geometry_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/counted.h"
#include "render/proxy/mesh_file.h"

namespace ulf::commands {
namespace {

std::string MapsInWords(const render::GeometryState& state) {
  if (state.maps + state.stale_maps == 0) return "no depth maps";
  if (state.stale_maps == 0) return Counted(state.maps, "depth map");
  return fmt::format("{} of {} fit the views as they are", state.maps,
                     Counted(state.maps + state.stale_maps, "depth map"));
}

std::string FitInWords(const render::GeometryState& state, std::size_t views) {
  if (!state.origin) return "the file does not tell what made it, and of which views";
  const std::size_t then = state.origin->views, left_out = state.origin->left_out;
  const std::string by = fmt::format(
      "by {} of {}{}", state.origin->made_by,
      left_out > 0 && left_out <= then ? fmt::format("{} of ", then - left_out) : "", Counted(then, "view"));
  if (state.has_views_of_mesh) return by + ", as they are now";
  return state.origin->views == views ? by + " when views, poses or lenses were others"
                                      : fmt::format("{}, where there are {} now", by, views);
}

// Returns "" if the views are too few for a mesh.
std::string MeshAdvice(const char* before, const LightField& light_field, const char* makes) {
  constexpr std::size_t kFewestViews = 2;
  return light_field.views.size() < kFewestViews
             ? std::string()
             : fmt::format("{}'{}' makes {}", before, render::ProxyCommand(light_field.root), makes);
}

}  // namespace

std::string GeometryText(const std::optional<render::GeometryState>& state, const LightField& light_field) {
  const auto advice = [&](const char* before, const char* makes) {
    return MeshAdvice(before, light_field, makes);
  };
  if (!state) return "geometry       no mesh" + advice("; ", "one, with depth maps") + "\n";
  const bool has_mesh = state->triangles > 0;
  std::string text = "geometry       ";
  if (!has_mesh)
    return text +
           (state->problem.empty() ? render::kMeshProxyFile + std::string(" has no triangles")
                                   : state->problem) +
           advice("; ", "it again") + "\n";
  text += fmt::format("{} of {} ({}); {}\n", render::kMeshProxyFile, Counted(state->triangles, "triangle"),
                      FitInWords(*state, light_field.views.size()),
                      state->problem.empty() ? MapsInWords(*state) : "depth maps that are not used");
  if (!state->problem.empty())
    return text + "               " + state->problem + "; the mesh is used" + advice("; ", "both anew") +
           "\n";
  if (state->IsOutdated())
    if (const std::string words = advice("               ", "both anew"); !words.empty())
      text += words + "\n";
  return text;
}

nlohmann::json GeometryJson(const std::optional<render::GeometryState>& state) {
  if (!state) return nullptr;
  nlohmann::json json{{"mesh", render::kMeshProxyFile},
                      {"triangles", state->triangles},
                      {"vertices", state->vertices},
                      {"made_by", nullptr},
                      {"views", nullptr},
                      {"left_out", nullptr},
                      {"fits", nullptr},
                      {"depth_maps", state->maps},
                      {"stale_depth_maps", state->stale_maps},
                      {"problem", nullptr}};
  if (state->origin) {
    json["made_by"] = state->origin->made_by;
    json["views"] = state->origin->views;
    json["left_out"] = state->origin->left_out;
  }
  if (state->mesh_fits) json["fits"] = *state->mesh_fits;
  if (!state->problem.empty()) json["problem"] = state->problem;
  return json;
}

std::vector<std::string> Outdated(const std::optional<render::GeometryState>& before,
                                  const std::optional<render::GeometryState>& after) {
  std::vector<std::string> files;
  if (!before || !after) return files;
  const bool maps = before->maps > after->maps;
  // A mesh without recorded views counts as fitting before the change unless its maps contradict.
  if ((before->mesh_fits.value_or(maps) && !after->mesh_fits.value_or(false)) || maps)
    files.emplace_back(render::kMeshProxyFile);
  if (maps) files.emplace_back(render::kDepthMapsFolder);
  return files;
}

std::string OutdatedText(const std::optional<render::GeometryState>& before,
                         const std::optional<render::GeometryState>& after, const std::string& made_for,
                         const LightField& light_field) {
  if (Outdated(before, after).empty()) return "";
  const std::size_t maps = before->maps - after->maps;
  return fmt::format("outdated: the mesh ({}){} made for {}{}{}\n", render::kMeshProxyFile,
                     maps > 0 ? fmt::format(" and {} (depth/) were", Counted(maps, "depth map")) : " was",
                     made_for, maps > 0 ? ", and these maps are not used any more" : "",
                     MeshAdvice("; ", light_field, maps > 0 ? "both anew" : "it anew"));
}

}  // namespace ulf::commands
