// Checks meshes that options name against photographs, where the light field has no points for it.
#pragma once

#include <string>

#include "render/proxy/triangle_mesh.h"

namespace ulf::commands {

// Throws Error if `mesh`, called `name` in texts, is in another world than the light field in `dir`
// (render/proxy/mesh_world.h). Where the light field has few points, they are measured in its photographs.
void RequireMeshOfLightField(const std::string& name, const render::TriangleMesh& mesh,
                             const std::string& dir);

// Does so for a proxy by its name if it is a mesh file, and render::ProxyFromName() cannot tell for want of
// points.
void RequireProxyOfLightField(const std::string& proxy, const std::string& dir);

}  // namespace ulf::commands
