// The recorded viewpoints as a triangle mesh around the subject (thesis, section 5.2).
//
// Directions (C - O)/|C - O| of the viewpoints C about the subject's centre O are triangulated on the sphere,
// or for comparison as the thesis does it, in the plane of their azimuth and elevation, which has a seam and
// two poles; the mesh's vertices are the viewpoints themselves, in world coordinates, triangles
// counter-clockwise as seen from outside. What the thesis leaves out:
//   Rim       A rim triangle goes when its circumscribed cap is wider than a few times the local spacing, but
//   only
//             while the rest stays in one piece and keeps every vertex (the characteristic shape of Duckham
//             et al. 2008). Wide triangles inside stay, with less confidence.
//   Duplicates Of viewpoints in nearly one direction one gives the vertex its place; the others stay as
//   alternates
//             for their distance.
//   Folds     While some triangle's plane cuts the subject's sphere (only then can a line through the subject
//   cross
//             the outer sheet twice), distances are smoothed: 0.75 own, 0.25 the neighbours' mean.
//   Outside   Each boundary vertex knows an outward way along the tangent, for extending the mesh past the
//   hull. Sets that span no surface (one view, two, a row, a ring, all in one place) say so in `span`.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/fields/triangle_topology.h"

namespace ulf::render {

enum class Span {
  kSurface,  // a mesh with an inside
  kLine,     // a row, a ring, or too few: no weights from a mesh, lumigraph weights serve
  kPlace,    // one view, or all in one place: the nearest view serves
};

struct ViewpointMesh {
  struct Vertex {
    Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();  // smoothed where the mesh folded
    std::vector<int> views = {};  // indices; the first gave the place, the others are its alternates
    // Outward along the tangent, its length in world units; zero inside.
    Eigen::Vector3d outward_in_world = Eigen::Vector3d::Zero();
  };

  Span span = Span::kPlace;
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;
  std::vector<double>
      confidence;  // of each triangle, 1 down to 0 where it is far wider than the local spacing
  int boundary_vertices = 0;
  int smoothing_rounds = 0;
  bool folds_remain = false;
  int groups =
      0;  // of views, with directions kOpeningRad or farther from group to group; 0: none has a direction
  double median_distance = 0;
  double mean_edge_rad = 0;  // mean angle of an edge as seen from the subject's centre

  // The view at a vertex whose distance to the subject is nearest to the given one.
  int ViewAt(int vertex, double distance, const std::vector<Eigen::Vector3d>& centers_in_world) const;
  bool OnBoundary(int vertex) const;
  // One line for people: what the viewpoints span and what that means for rendering.
  std::string Description() const;
};

struct ViewpointMeshOptions {
  bool in_plane = false;  // azimuth and elevation about `up_in_world`
  Eigen::Vector3d up_in_world = -Eigen::Vector3d::UnitY();
};

// Views at the subject's centre have no direction and are left out.
ViewpointMesh MakeViewpointMesh(const std::vector<Eigen::Vector3d>& centers_in_world, const Subject& subject,
                                const ViewpointMeshOptions& options = {});

// Whether a direction from the subject's centre meets the mesh.
bool InsideHull(const ViewpointMesh& mesh, const Eigen::Vector3d& direction_in_world);

// A rim triangle goes when its circumscribed cap is wider than this many times the local spacing.
inline constexpr double kWideTriangle = 3.0;
// A gap that a cap of this radius fits into is an opening, not a hole: trimming starts there.
inline constexpr double kOpeningRad = 60.0 * 3.14159265358979323846 / 180.0;
// Directions closer than this share of the local spacing share a vertex.
inline constexpr double kDuplicateShare = 0.1;
inline constexpr int kMaxSmoothingRounds = 20;
// The mesh is a surface when at least this share of its vertices is inside.
inline constexpr double kMinInteriorShare = 0.1;

}  // namespace ulf::render
