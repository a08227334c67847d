// Whose the mesh of a light field is, and whether mesh and depth maps fit its views as they are now. The
// mesh's file tells it in comments of its header (docs/light_field.md): which command made it, how many views
// there were, how many of them it was made without, and a digest of the views' numbers, poses and cameras.
// Meshes of other programs, and of earlier versions of this one, tell nothing.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf::render {

struct MeshOrigin {
  std::string made_by;       // "ulf capture", "ulf proxy"
  std::size_t views = 0;     // that there were
  std::size_t left_out = 0;  // of these: there was no time for them, or they could not be read
  std::string digest;        // of the views that there were
};
// The comments for a mesh that is made of `light_field` as it is, without so many of its views.
std::vector<std::string> OriginComments(const std::string& made_by, const LightField& light_field,
                                        std::size_t left_out = 0);

struct GeometryState {
  std::size_t triangles = 0, vertices = 0;  // 0: the mesh cannot be read
  std::optional<MeshOrigin> origin;         // none: the file does not tell
  // Of all views, under their poses and cameras as they are now; none: the file does not tell.
  std::optional<bool> mesh_fits;
  bool has_views_of_mesh = false;  // they are as they were, though the mesh may be made without some
  std::size_t maps = 0;            // that are used
  std::size_t stale_maps =
      0;                // of views that are gone, or have another pose or camera now, or beside another mesh
  std::string problem;  // why the mesh, or the maps, cannot be read; empty: they can

  bool IsOutdated() const { return mesh_fits == false || stale_maps > 0; }
};
// None: there is no mesh. Reads the mesh, as whoever renders does, and the index of the maps.
std::optional<GeometryState> GeometryStateOf(const LightField& light_field);

}  // namespace ulf::render
