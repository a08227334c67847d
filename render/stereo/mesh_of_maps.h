// Makes the mesh of several depth maps: depths on which they agree become points, and the points a surface.
// It also converts the maps for the soft field. `ulf proxy` and a running capture (growing_geometry.h) share
// these steps.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"
#include "render/proxy/view_depth_map.h"
#include "render/stereo/depth_fusion.h"

namespace ulf::render {

struct MapsMeshOptions {
  // Points are spaced wider until they are at most half of this number: they give about twice as many
  // triangles. Measured (docs/measured/speed_and_accuracy.md: beyond 77,000 triangles more hardly help).
  int most_triangles = 400000;
  bool in_this_thread = false;  // otherwise on all processors
};

struct MapsMesh {
  TriangleMesh mesh;          // without triangles if the maps agree on no surface
  double agreeing_share = 0;  // of the maps' pixels
  std::size_t points = 0;
  double fusion_s = 0, surface_s = 0;  // durations of the two steps
};

MapsMesh MeshOfMaps(std::vector<ViewDepth> maps, const Subject& subject, const MapsMeshOptions& options = {});

// Returns a map for each of `maps`, by View::id: its depths where other maps confirm them, and elsewhere
// those of `mesh`, which is MeshOfMaps() of the same maps. `view_ids[i]` belongs to maps[i].
std::map<int, ViewDepthMap> MapsForRendering(std::vector<ViewDepth> maps, const std::vector<int>& view_ids,
                                             const TriangleMesh& mesh, const Subject& subject,
                                             const MapsMeshOptions& options = {});

}  // namespace ulf::render
