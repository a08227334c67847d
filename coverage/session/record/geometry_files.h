// Writes the geometry that a capture has made into its light field: mesh and depth maps together. Files that
// were there before move to another name, and one line says where.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "coverage/session/record/live_geometry.h"

namespace ulf::coverage {

// Returns the light field's depth maps that fit its views' poses. Pixels that do not show the mesh have no
// depth, because it was filled in there or nothing confirmed it. Returns an empty list where there are no
// maps, or they cannot be read.
std::vector<KnownMap> ReadKnownMaps(const LightField& light_field);

// Returns in words why the mesh and the depth maps that are there are better than those that a capture has
// made: there are more maps, or larger ones, or some where the new geometry has none; a mesh without maps is
// better if it has more triangles. Returns an empty text when the new geometry is at least as good, or the
// old one cannot be read or is of other poses. `finished` has a mesh.
std::string WhyExistingIsBetter(const std::filesystem::path& root, const FinishedGeometry& finished);

// Writes into a closed light field. `finished` has a mesh; its maps are taken out and written_maps is set. No
// failure is thrown: `say` gets what cannot be written, and the light field keeps its former mesh (then
// `finished` has none), or gets the mesh without maps.
void WriteGeometry(const std::filesystem::path& root, FinishedGeometry& finished,
                   const std::function<void(const std::string&)>& say);

}  // namespace ulf::coverage
