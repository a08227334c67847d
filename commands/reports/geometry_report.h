// Reports the mesh and the depth maps of a light field: their origin, and whether they fit its views as they
// are now. `state` is none if there is no mesh.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/proxy/geometry_state.h"

namespace ulf::commands {

// Returns one or two lines of `ulf info`, with the command that makes missing or outdated geometry.
std::string GeometryText(const std::optional<render::GeometryState>& state, const LightField& light_field);
nlohmann::json GeometryJson(const std::optional<render::GeometryState>& state);  // null without a mesh

// Returns what fitted before a change of the views and no longer does: "proxy.ply", "depth".
std::vector<std::string> Outdated(const std::optional<render::GeometryState>& before,
                                  const std::optional<render::GeometryState>& after);
// Returns a line that names what is outdated and the remedy, or "". `made_for`: "the poses before".
std::string OutdatedText(const std::optional<render::GeometryState>& before,
                         const std::optional<render::GeometryState>& after, const std::string& made_for,
                         const LightField& light_field);

}  // namespace ulf::commands
