// Finds the subject in its sphere by a mesh of the scene, and how large it really is, as far as it was seen.
// The plane that it stands on, and what lies behind that plane, is left out; of the rest, connected surfaces
// in the sphere count whole.
#pragma once

#include <optional>

#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

// Returns none if nothing stands apart in the sphere: no surface, or one that continues into the scene (a
// picture on its wall, an object whose gaps are bridged).
std::optional<Subject> SubjectInMesh(const TriangleMesh& mesh, const Subject& sphere);

}  // namespace ulf::render
