// The surface between what views saw through and what they saw: space is cut into the Delaunay tetrahedra of
// the points, every line of sight from a camera to a point it sees says that the tetrahedra on it are empty
// and that the one behind the point is not, and a minimum cut finds the labels that contradict the fewest
// (Labatut, Pons, Keriven 2009; with the soft visibility of Vu et al. 2012). The surface adapts to the
// density of the points, from the subject to the far background, needs no normals, and closes over what no
// view looked at.
#pragma once

#include <vector>

#include "render/proxy/triangle_mesh.h"
#include "render/stereo/depth_fusion.h"

namespace ulf::render {

struct SurfaceOptions {
  int sight_lines = 6;      // of a point, at most
  double softness = 0.25;   // in spreads of a point: how far from it the surface may lie
  double behind = 1.0;      // in spreads: there it is not empty
  double regularity = 0.1;  // against thin tetrahedra at the surface, in lines of sight
  // Of a triangle, in its points' pixels: nobody saw what lies between points farther apart, it is left open.
  double longest_edge_px = 60;
};

struct ReconstructedSurface {
  TriangleMesh mesh;
  std::vector<std::uint32_t> point_of_vertex;  // index into the points
};

// `centers_in_world`: of the views that the points name. Empty where the points span no volume.
ReconstructedSurface CutSurface(const std::vector<FusedPoint>& points,
                                const std::vector<Eigen::Vector3d>& centers_in_world,
                                const SurfaceOptions& options = {});

}  // namespace ulf::render
