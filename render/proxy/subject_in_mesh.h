// Finds the subject's place and size by a mesh of the scene, from a sphere that contains it roughly. The
// plane on which it stands, and what lies behind that plane, is left out; of the rest, connected surfaces
// whose middle is in the sphere count whole.
#pragma once

#include <optional>

#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

// Returns the smallest ball around nearly all of these surfaces, as far as they were seen. Returns none if
// nothing stands apart in the sphere: no surface, or one that continues into the scene (a picture on its
// wall, an object whose gaps are bridged), which gives a ball of more than twice the sphere's radius.
std::optional<Subject> SubjectInMesh(const TriangleMesh& mesh, const Subject& sphere);

}  // namespace ulf::render
