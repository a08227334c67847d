// The mesh of several depth maps: what they agree on becomes points, and the points a surface. And the maps
// as the soft field wants them. The steps that `ulf proxy` and a running capture (growing_geometry.h) share.
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
  // About: the points are spaced wider until there are half as many. Measured
  // (docs/measured/speed_and_accuracy.md: beyond 77,000 triangles more hardly help).
  int most_triangles = 400000;
  bool in_this_thread = false;  // otherwise on all processors
};

struct MapsMesh {
  TriangleMesh mesh;          // without triangles where the maps agree on no surface
  double agreeing_share = 0;  // of the maps' pixels
  std::size_t points = 0;
  double fusion_s = 0, surface_s = 0;
};

MapsMesh MeshOfMaps(std::vector<ViewDepth> maps, const Subject& subject, const MapsMeshOptions& options = {});

// By View::id: what the maps say where others confirm it, and elsewhere `mesh`, which is MeshOfMaps() of the
// same maps. `view_ids[i]`: of maps[i].
std::map<int, ViewDepthMap> MapsForRendering(std::vector<ViewDepth> maps, const std::vector<int>& view_ids,
                                             const TriangleMesh& mesh, const Subject& subject,
                                             const MapsMeshOptions& options = {});

}  // namespace ulf::render
