// A proxy of a few planes: those of plane_search, each cut to the extent of its points, as one mesh.
//
// A grid about as fine as the points' spacing cuts a plane. A cell with points is kept. So is a cell beside
// one, or inside the convex hull of connected points (walls have few features), unless more than one point
// behind the plane was seen through it: then it is an opening, or beyond an edge. Isolated points, far from
// the others of their plane, are accidental intersections with other surfaces and do not count.
#pragma once

#include <memory>

#include "render/proxy/plane_search.h"
#include "render/proxy/proxy.h"

namespace ulf::render {

inline constexpr char kPlanesProxy[] = "planes";

// Returns the cut planes as one mesh. `light_field` has the points in which they were found.
std::shared_ptr<const TriangleMesh> MeshOfPlanes(const std::vector<FoundPlane>& planes,
                                                 const LightField& light_field);

// Logs how many planes there are and what share of the points lies on them. Throws Error if there are none.
std::shared_ptr<const Proxy> MakePlanesProxy(const Subject& subject, const LightField& light_field);

}  // namespace ulf::render
