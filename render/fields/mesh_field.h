// Weights read where the line through the virtual camera's centre V along a pixel's ray crosses the mesh of
// viewpoints, on the sheet that the ray enters from outside (ray . outward normal < 0).
//
// For a triangle with corners v_k the line's crossing is ray = sum_k lambda_k (v_k - V): all lambda positive,
// it lies before V; all negative, behind V. On the facing sheet the first happens exactly when V is outside
// the triangle's plane, the second when V is inside it. So each triangle is taken once, with corners s (v_k -
// V), s = 1 or -1 by V's side, and a ray crosses it where the inverse of that corner matrix times the ray is
// non-negative; normalised, this is the barycentric coordinate. (OpenGL: negating a vertex's four clip
// coordinates leaves its image point.) When V stands on the mesh, every ray crosses at V while all triangles
// are seen edge-on: V is moved off along the direction from the subject to a thousandth of the local edge, so
// that the triangle at V covers the image.
//
// Outside the hull the boundary is extended outward by strips whose weights copy the boundary's. Where
// triangles overlap (strips across a hollow rim, a fold that smoothing left) the last in order counts; strips
// come first.
#pragma once

#include <memory>

#include "render/fields/blending_field.h"
#include "render/fields/loop_subdivision.h"

namespace ulf::render {

struct FieldMesh {
  int level = 0;                                // of subdivision
  std::vector<Eigen::Vector3d> positions = {};  // in world; the viewpoint mesh's vertices first
  std::vector<SparseWeights> weights = {};      // of each vertex over the viewpoint mesh's vertices
  std::vector<int> extends = {};                // of a vertex of the extension its rim vertex, else -1
  std::vector<Triangle> triangles = {};         // the extension's strips first
  std::vector<double> confidence = {};          // of each triangle
  std::size_t strips = 0;                       // how many triangles belong to the extension
};

FieldMesh MakeFieldMesh(const ViewpointMesh& mesh, int level);

// The field mesh as seen from one place.
struct PlacedMesh {
  Eigen::Vector3d virtual_center_in_world;  // V, moved off the mesh where it stood on it
  std::vector<Eigen::Matrix3d> corners;     // columns: s (v_k - V), in world axes
  std::vector<Eigen::Matrix3d>
      cone_from_ray;                // inverse of the former; zero where V lies in the triangle's plane
  std::vector<int> view_of_vertex;  // for each vertex of the viewpoint mesh the view that serves from here
};

class MeshField : public BlendingField {
 public:
  MeshField(std::shared_ptr<const RenderScene> scene, int level);
  std::unique_ptr<FieldFromHere> From(const Eigen::Vector3d& virtual_center_in_world) const override;

  PlacedMesh Place(const Eigen::Vector3d& virtual_center_in_world) const;
  const FieldMesh& field_mesh() const { return *mesh_; }
  const Eigen::Vector3d& center_in_world() const { return scene_->mesh.center_in_world; }

 private:
  Eigen::Vector3d OffTheMesh(const Eigen::Vector3d& virtual_center_in_world) const;

  std::shared_ptr<const RenderScene> scene_;
  std::vector<Eigen::Vector3d> centers_;
  std::shared_ptr<const FieldMesh> mesh_;  // what From() gives keeps it, too
  std::vector<Eigen::Matrix3d>
      cone_from_direction_;  // the same from the subject's centre: finds the triangle at V
};

// V nearer to the mesh than this share of the local edge counts as standing on it.
inline constexpr double kOnMeshShare = 1e-3;

}  // namespace ulf::render
