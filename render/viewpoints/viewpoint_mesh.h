// The recorded viewpoints as a triangle mesh around the subject (thesis, section 5.2).
//
// C are the viewpoints, O the subject's centre. The directions (C - O)/|C - O| are triangulated on the unit
// sphere (or, for comparison, in the plane of azimuth and elevation as in the thesis, which has a seam and
// two poles). The mesh's vertices are the viewpoints themselves in world coordinates; its triangles are
// counter-clockwise as seen from outside. The thesis leaves four cases out:
//
//   Rim         A rim triangle is removed when the radius of its circumscribed cap is a few times the local
//               spacing, as long as the rest stays in one piece and keeps every vertex (the characteristic
//               shape of Duckham et al. 2008). Wide triangles inside the mesh stay, with less confidence, up
//               to a radius of 60 degrees: wider ones are openings, and none of them stays.
//   Duplicates  One of several viewpoints in nearly the same direction gives the vertex its position. The
//               others become its alternates, for cameras at their distance.
//   Folds       While the plane of some triangle cuts the subject's sphere, the distances are smoothed (0.75
//               own, 0.25 mean of the neighbours). Only a folded mesh lets a line through the subject cross
//               the outer sheet twice.
//   Outside     Each boundary vertex has an outward tangent, along which the mesh is extended past the hull.
//
// Sets that span no surface (one view, two, a row, a ring, all in one place) are marked by `span`.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/viewpoints/triangle_topology.h"

namespace ulf::render {

enum class Span {
  kSurface,  // a mesh of whose vertices at least a tenth is interior
  kLine,     // a row, a ring, or too few views: lumigraph weights are used instead of a mesh
  kPlace,    // one view, all views in one place, or all at the subject's centre: the nearest view is used
};

struct ViewpointMesh {
  struct Vertex {
    Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();  // smoothed if the mesh folded
    std::vector<int> views = {};  // view indices; the first gives the position, the others are alternates
    // Outward tangent, with its length in world units; zero for interior vertices.
    Eigen::Vector3d outward_in_world = Eigen::Vector3d::Zero();
  };

  Span span = Span::kPlace;
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;
  // Per triangle: 1, or less (down to 0) if the triangle is far wider than the local spacing.
  std::vector<double> confidence;
  int boundary_vertices = 0;
  int smoothing_rounds = 0;
  bool folds_remain = false;
  // Number of groups of views, at least 60 degrees apart as seen from the subject's centre; 0 for kPlace.
  int groups = 0;
  double median_distance = 0;  // of the views to the subject's centre, world units
  double mean_edge_rad = 0;    // mean angle of an edge as seen from the subject's centre; 0 unless kSurface

  // Returns that view of a vertex whose distance to the subject's centre is nearest to `distance` (world
  // units). `centers_in_world` are those of all views.
  int ViewAt(int vertex, double distance, const std::vector<Eigen::Vector3d>& centers_in_world) const;
  bool OnBoundary(int vertex) const;
  // Describes for people, in a line, what the viewpoints span, and what is rendered from them.
  std::string Description() const;
};

struct ViewpointMeshOptions {
  bool in_plane = false;  // triangulate in the plane of azimuth and elevation about `up_in_world`
  Eigen::Vector3d up_in_world = -Eigen::Vector3d::UnitY();
};

// A mesh that still folds after this many rounds of smoothing stays folded (`folds_remain`). Guessed.
inline constexpr int kMostSmoothingRounds = 20;

// Makes the mesh of all views, whose indices are those of `centers_in_world`. Views at the subject's centre
// have no direction and are ignored.
ViewpointMesh MakeViewpointMesh(const std::vector<Eigen::Vector3d>& centers_in_world, const Subject& subject,
                                const ViewpointMeshOptions& options = {});

// Returns whether the ray from the subject's centre in this direction meets the mesh.
bool InsideHull(const ViewpointMesh& mesh, const Eigen::Vector3d& direction_in_world);

// Returns whether a point is so near the subject's centre that it has no direction from there.
inline bool IsAtCenter(const Subject& subject, const Eigen::Vector3d& point_in_world) {
  // Rounding, as a share of the subject's radius or of one world unit, the larger.
  constexpr double kLeastShare = 1e-9;
  return !((point_in_world - subject.center_in_world).norm() > kLeastShare * std::max(1.0, subject.radius));
}

}  // namespace ulf::render
