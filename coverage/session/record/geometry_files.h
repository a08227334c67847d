// How the geometry that a capture has made becomes its light field's: the mesh first, then its depth maps. What was there
// is kept, and one line says where.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "coverage/session/record/live_geometry.h"

namespace ulf::coverage {

// Of a closed light field. `finished` has a mesh; takes its maps and sets written_maps. Throws nothing: what cannot be
// written goes to `say`, in words, and the light field has the mesh of before (then `finished` has none), or no maps.
void WriteGeometry(const std::filesystem::path& root, FinishedGeometry& finished,
                   const std::function<void(const std::string&)>& say);

}  // namespace ulf::coverage
