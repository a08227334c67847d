// Reports the mesh and the depth maps of a light field in a line: their origin, and whether they fit its
// views as they are now.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/proxy/geometry_state.h"

namespace ulf::commands {

// Returns a line of `ulf info`; without a mesh, it names the command that makes one.
std::string GeometryText(const std::optional<render::GeometryState>& state, const LightField& light_field);
nlohmann::json GeometryJson(const std::optional<render::GeometryState>& state);  // null without a mesh

// Returns the files that no longer fit after a change ("proxy.ply", "depth"), of those that did `before`.
std::vector<std::string> Outdated(const std::optional<render::GeometryState>& before,
                                  const std::optional<render::GeometryState>& after);
// Returns a line that names them and the remedy; empty if none is outdated. `made_for`: "the poses before".
std::string OutdatedText(const std::optional<render::GeometryState>& before,
                         const std::optional<render::GeometryState>& after, const std::string& made_for,
                         const LightField& light_field);

}  // namespace ulf::commands
