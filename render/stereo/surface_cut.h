// Extracts the surface between the free space that views saw through and the points that they saw. Space is
// divided into the Delaunay tetrahedra of the points. A line of sight from a camera to a point that it sees
// is evidence that the tetrahedra on the line are empty and the one behind the point is filled; a minimum cut
// finds the labels, empty or filled, that contradict the least evidence (Labatut, Pons, Keriven 2009; with
// the soft visibility of Vu et al. 2012). The surface adapts to the density of the points, from the subject
// to the far background, needs no normals, and closes over unseen parts of less than 60 px.
#pragma once

#include <vector>

#include "render/proxy/triangle_mesh.h"
#include "render/stereo/depth_fusion.h"

namespace ulf::render {

// `centers_in_world` are those of the views in FusedPoint::seen_by. Runs on all processors unless
// `in_this_thread`. Returns an empty mesh if the points span no volume.
TriangleMesh CutSurface(const std::vector<FusedPoint>& points,
                        const std::vector<Eigen::Vector3d>& centers_in_world, bool in_this_thread = false);

}  // namespace ulf::render
