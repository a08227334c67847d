// The blending field of a wide aperture (thesis, section 5.5).
//
// V is the virtual camera's centre, a the radius of its aperture, f the depth of the focal plane. A view W at
// depth z (both depths along V's axis) contributes the rays through W and the aperture. The rays that meet in
// one point of the focal plane cross W's depth in a disc of radius
//
//   b = a (1 - z / f)
//
// parallel to the aperture. The disc of this radius around W is W's outline, whether W stands before V,
// behind it or in its plane (there W contributes everywhere if |W - V| <= a, else nowhere). A view beyond the
// focal plane has no outline. Outlines shrink to nothing over the last degrees before a view's part of the
// mesh is seen from behind.
//
// The ring of W is the set of triangles over which W's weight falls to zero. It is warped so that its
// boundary reaches the outline: a vertex moves away from W, parallel to the image plane, to the distance b
// times its topological distance from W over that of the boundary. A vertex that is already as far away
// stays, so that an aperture smaller than the viewpoints' spacing changes nothing. A vertex that moves also
// comes into W's depth, in the same proportion. Vertices of the mesh's extension follow their rim vertices.
//
// The weights of all rings are added and normalised. Without an aperture this is not quite the ordinary
// field: where triangles overlap (at a ragged rim) the ordinary field counts only one, the rings count all.
// Therefore the ordinary field is added with weight 1 against the weight `share` of the rings. `share` is 0
// while nothing has moved and grows without bound, so that the field is continuous in the radius.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "render/fields/aperture.h"
#include "render/fields/blending_field.h"
#include "render/fields/mesh_field.h"

namespace ulf::render {

// A triangle of one view's warped ring.
struct WarpedTriangle {
  int triangle = 0;                        // index in FieldMesh::triangles
  int vertex = 0;                          // of the viewpoint mesh: the ring's centre
  Eigen::Vector3d weights;                 // the view's, at the corners
  Eigen::Matrix3d corners, cone_from_ray;  // as in PlacedMesh, but in the camera's axes
};

struct WarpedRings {
  double share = 0;  // 0: no vertex has moved, and the rings equal the ordinary field
  std::vector<WarpedTriangle> triangles;
};

// Makes the rings of a field once, and warps them for each camera and aperture.
class ApertureField {
 public:
  explicit ApertureField(std::shared_ptr<const MeshField> field);
  // Returns the rings for a camera and an aperture. `placed` is MeshField::Place() of the camera's centre.
  WarpedRings Warp(const PlacedMesh& placed, const Rigid3& cam_from_world, const Aperture& aperture) const;
  // Returns the weights of all rays through the aperture that meet a point of the focal plane; the ordinary
  // field's weights if nothing moved. The result may outlive this object.
  std::unique_ptr<PlacedField> From(const Rigid3& cam_from_world, const Aperture& aperture) const;

 private:
  struct Part {
    int triangle;
    std::array<int, 3> corners;  // indices into Ring::vertices
    Eigen::Vector3d weights;
  };
  struct Ring {
    std::vector<int> vertices;   // of the field mesh
    std::vector<double> shares;  // per vertex: topological distance, divided by the boundary's
    std::vector<int> extends;    // per vertex of the extension: its rim vertex here; else -1
    std::vector<Part> parts;
  };
  struct WarpedVertices;
  void MakeRings();
  WarpedVertices WarpVertices(std::size_t ring, const PlacedMesh& placed, const Rigid3& cam_from_world,
                              const Aperture& aperture) const;

  std::shared_ptr<const MeshField> field_;
  std::vector<Ring> rings_;  // one for each vertex of the viewpoint mesh
};

}  // namespace ulf::render
