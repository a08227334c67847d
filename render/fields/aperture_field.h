// The blending field of a wide aperture (thesis, section 5.5).
//
// A view W gives the rays that go from it through the aperture, a disc of radius a about V. Seen from a point
// of the focal plane (depth f; W at depth z, both along V's axis), they pass W's own depth within
//   b = a (1 - z / f)
// of W. That disc about W, parallel to the aperture, is W's outline, wherever W stands: before V, behind it,
// or in its plane, where W contributes everywhere if |W - V| <= a, else nowhere. A view beyond the focal
// plane has none, and outlines shrink to nothing over the last degrees before a view's part of the mesh is
// seen from behind.
//
// W's ring, the triangles over which its weight falls to zero, is warped so that its boundary reaches the
// outline. Its vertices move away from W, parallel to the image plane, each to the share of b that its
// topological distance to W is of the boundary's; one that is as far already stays, so that nothing changes
// while the aperture is smaller than the viewpoints' spacing. What moved comes into W's own depth, in the
// same measure as it moved. Vertices of the mesh's extension follow their rim vertices.
//
// Weights of all rings are added up and normalised. Where triangles of the ordinary field overlap (at a
// ragged rim) one of them counts, of rings all do; so the ordinary field is added as well, with weight 1
// against `share` of the rings, which grows without bounds from 0 where nothing has moved: the field is
// continuous in the radius.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "render/fields/aperture.h"
#include "render/fields/mesh_field.h"

namespace ulf::render {

// A triangle of one view's warped ring, in the camera's axes.
struct WarpedTriangle {
  int triangle = 0;                        // of the field mesh
  int vertex = 0;                          // of the viewpoint mesh: whose ring this is
  Eigen::Vector3d weights;                 // at the corners
  Eigen::Matrix3d corners, cone_from_ray;  // as in PlacedMesh
};

struct WarpedRings {
  double share = 0;  // 0: nothing has moved, these are the ordinary field, cut up
  std::vector<WarpedTriangle> triangles;
};

class ApertureField {
 public:
  explicit ApertureField(std::shared_ptr<const MeshField> field);
  // `placed` from the camera's centre.
  WarpedRings Warp(const PlacedMesh& placed, const Rigid3& cam_from_world, const Aperture& aperture) const;
  // Weights of all rays through the aperture that meet a point of the focal plane; the ordinary field's where
  // nothing moved. Stands on its own.
  std::unique_ptr<FieldFromHere> From(const Rigid3& cam_from_world, const Aperture& aperture) const;

 private:
  struct Part {
    int triangle;
    std::array<int, 3> corners;  // indices into Ring::vertices
    Eigen::Vector3d weights;
  };
  struct Ring {
    std::vector<int> vertices;   // of the field mesh
    std::vector<double> shares;  // of each: topological distance over the boundary's
    std::vector<int> extends;    // of each vertex of the extension its rim vertex here, else -1
    std::vector<Part> parts;
  };
  struct WarpedVertices;
  void MakeRings();
  WarpedVertices WarpVertices(std::size_t ring, const PlacedMesh& placed, const Rigid3& cam_from_world,
                              const Aperture& aperture) const;

  std::shared_ptr<const MeshField> field_;
  std::vector<Ring> rings_;  // of each vertex of the viewpoint mesh
};

}  // namespace ulf::render
