// Whose the mesh of a light field is, and whether mesh and depth maps fit its views as they are now. The mesh's file tells
// it in comments of its header (docs/disk_format.md): which command made it, of how many views, and a digest of these
// views' numbers, poses and cameras. Meshes of other programs, and of earlier versions of this one, tell nothing.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf::render {

struct MeshOrigin {
  std::string made_by;  // "ulf capture", "ulf proxy"
  std::size_t views = 0;
  std::string digest;  // of the views then
};
// The comments for a mesh that is made of `light_field` as it is.
std::vector<std::string> OriginComments(const std::string& made_by, const LightField& light_field);

struct GeometryState {
  std::size_t triangles = 0, vertices = 0;  // 0: the mesh cannot be read
  std::optional<MeshOrigin> origin;         // none: the file does not tell
  // Of all views, under their poses and cameras as they are now; none: the file does not tell.
  std::optional<bool> mesh_fits;
  std::size_t maps = 0;  // that are used
  std::size_t stale_maps =
      0;                // of views that are gone, or have another pose or camera now, or beside another mesh
  std::string problem;  // why the mesh, or the maps, cannot be read; empty: they can

  bool IsOutdated() const { return mesh_fits == false || stale_maps > 0; }
};
// None: there is no mesh. Reads the mesh, as whoever renders does, and the index of the maps.
std::optional<GeometryState> GeometryStateOf(const LightField& light_field);

// The command that makes mesh and maps, for messages: "ulf proxy vase".
std::string ProxyCommand(const std::filesystem::path& light_field);

}  // namespace ulf::render
