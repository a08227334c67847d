// The surface between the space that views saw through and the points that they saw. Space is divided into
// the Delaunay tetrahedra of the points. A line of sight from a camera to a point that it sees is evidence
// that the tetrahedra on it are empty and the one behind the point is filled; a minimum cut finds the labels
// that contradict the least evidence (Labatut, Pons, Keriven 2009; with the soft visibility of Vu et al.
// 2012). The surface adapts to the density of the points, from the subject to the far background, needs no
// normals, and closes over what no view looked at.
#pragma once

#include <vector>

#include "render/proxy/triangle_mesh.h"
#include "render/stereo/depth_fusion.h"

namespace ulf::render {

struct SurfaceOptions {
  int sight_lines = 6;      // of a point, at most. Guessed.
  double softness = 0.25;   // distance from a point, in its spreads, at which evidence is weaker. Guessed.
  double behind = 1.0;      // distance behind a point, in its spreads, where space is filled. Guessed.
  double regularity = 0.1;  // weight against thin tetrahedra at the surface, in lines of sight. Guessed.
  // Triangles with a longer edge (in pixels at its points) are left out: no view saw what lies between.
  // Guessed.
  double longest_edge_px = 60;
  // Triangles whose edges are no longer are always kept. Of those between, some view that saw a corner must
  // stand in front. Guessed.
  double neighbours_px = 10;
  bool in_this_thread = false;  // otherwise on all processors
};

// `centers_in_world`: of the views in FusedPoint::seen_by. Empty where the points span no volume.
TriangleMesh CutSurface(const std::vector<FusedPoint>& points,
                        const std::vector<Eigen::Vector3d>& centers_in_world,
                        const SurfaceOptions& options = {});

}  // namespace ulf::render
