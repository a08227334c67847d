// Tells whether a mesh by another program lies in the light field's world, by what views see through it: the
// points that a view sees must lie on the mesh. A mesh of a part of the scene, or a rough one, may hold only
// some of them. For one that does not fit, the usual reasons are tried: axes that are exchanged or turned by
// right angles (y up for z up), another unit of length, another origin.
#pragma once

#include <string>

#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

// Fewer points of a light field do not tell.
inline constexpr std::size_t kFewestPointsForMesh = 50;

// Throws Error if the mesh does not fit the points of the light field, with the turn, scale or shift that
// would make it fit, or saying that none does. Warns where this cannot be told. `name` is the mesh's for
// texts.
void RequireMeshOfWorld(const std::string& name, const TriangleMesh& mesh, const LightField& light_field);

}  // namespace ulf::render
