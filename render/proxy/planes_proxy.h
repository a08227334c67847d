// A few planes as geometry: those of plane_search, each cut to where its points are, as one mesh.
//
// A plane is cut by a grid about as fine as its points are apart. A cell is kept where it has points or is
// beside one that has, and inside the convex hull of points that hang together (walls have few features); but
// not where more points behind it were seen through it than it has itself: an opening, or what is beside an
// edge. Points alone, far from the others of their plane, are where it happens to cut something else.
#pragma once

#include <memory>

#include "render/proxy/plane_search.h"
#include "render/proxy/proxy.h"

namespace ulf::render {

inline constexpr char kPlanesProxy[] = "planes";

// The planes, cut. `light_field`: whose points they were found in.
std::shared_ptr<const TriangleMesh> MeshOfPlanes(const std::vector<FoundPlane>& planes,
                                                 const LightField& light_field);

// Logs how many planes there are and what share of the points lies on them. Throws Error where
// there are none.
std::shared_ptr<const Proxy> MakePlanesProxy(const Subject& subject, const LightField& light_field);

}  // namespace ulf::render
