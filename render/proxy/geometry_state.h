// Determines the origin of a light field's mesh, and whether mesh and depth maps fit its views as they are
// now. Comments in the header of the mesh's file hold its origin (docs/light_field.md): which command made
// it, how many views there were, how many of them it was made without, and a digest of the views' numbers,
// poses and cameras. Meshes of other programs lack them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf::render {

struct MeshOrigin {
  std::string made_by;       // "ulf capture", "ulf proxy"
  std::size_t views = 0;     // number of views then
  std::size_t left_out = 0;  // views not used, for lack of time or because they could not be read
  std::string digest;        // of all views then
};
// Returns the comments for a mesh that is made of `light_field` as it is, without `left_out` of its views.
std::vector<std::string> OriginComments(const std::string& made_by, const LightField& light_field,
                                        std::size_t left_out = 0);

struct GeometryState {
  std::size_t triangles = 0, vertices = 0;  // 0: the mesh cannot be read
  std::optional<MeshOrigin> origin;         // none: not in the file
  // Whether the mesh uses all views with their present poses and cameras; none: the file does not tell.
  std::optional<bool> mesh_fits;
  bool has_views_of_mesh = false;  // whether these are the views of then, though it may not use them all
  std::size_t maps = 0;            // number of valid maps
  std::size_t stale_maps = 0;      // number of maps of views that were removed or changed
  std::string problem;  // why mesh or maps cannot be read (maps of another mesh, for one); empty: they can

  bool IsOutdated() const { return mesh_fits == false || stale_maps > 0; }
};
// Reads the mesh and the index of the maps. Returns none if there is no mesh file.
std::optional<GeometryState> GeometryStateOf(const LightField& light_field);

}  // namespace ulf::render
