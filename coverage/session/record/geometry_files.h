// Writes the geometry that a capture has made into its light field: mesh and depth maps together. Replaced
// files are kept, and one line says where.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "coverage/session/record/live_geometry.h"

namespace ulf::coverage {

// Returns the depth maps that the light field has and that fit its views, as far as they show the mesh: what
// they have beside it was filled in, or nothing confirmed it. It is empty where there are none, or they
// cannot be read.
std::vector<KnownMap> ReadKnownMaps(const LightField& light_field);

// Returns why the mesh and the depth maps that are there are better than those that a capture has made, in
// words: made of more maps, or of larger ones, or where the new ones have none; of a mesh without maps:
// finer. It is empty when the new ones are at least as good, or what is there cannot be read or is of other
// poses. `finished` has a mesh.
std::string WhyExistingIsBetter(const std::filesystem::path& root, const FinishedGeometry& finished);

// Writes into a closed light field. `finished` has a mesh; takes its maps and sets written_maps. Throws
// nothing: `say` gets what cannot be written, and the light field keeps its former mesh (then `finished` has
// none), or has no maps.
void WriteGeometry(const std::filesystem::path& root, FinishedGeometry& finished,
                   const std::function<void(const std::string&)>& say);

}  // namespace ulf::coverage
