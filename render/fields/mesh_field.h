// Weights by where the line through the virtual camera's centre V along a pixel's ray crosses the mesh of
// viewpoints, on the sheet that the ray enters from outside (ray . outward normal < 0).
//
// The line crosses a triangle with corners v_k at ray = sum_k lambda_k (v_k - V). If all lambda are positive,
// the crossing lies in front of V; if all are negative, behind it. On the facing sheet the first holds
// exactly when V is outside the triangle's plane, the second when V is inside. Therefore each triangle is
// used once, with the corners s (v_k - V) and s = 1 or -1 by the side of V. A ray crosses it where the
// inverse of that corner matrix times the ray is not negative; normalised, this is the barycentric
// coordinate. (In OpenGL a vertex keeps its image point when all four clip coordinates are negated.)
//
// When V stands on the mesh, every ray crosses it at V, and the triangles around V are seen edge-on. Then V
// is moved off the mesh, along the direction from the subject, so that the triangle at V covers the image.
//
// Outside the hull, strips extend the boundary outward; their weights are the boundary's. Where triangles
// overlap (strips across a hollow rim, or a fold that smoothing left), the last one counts; strips come
// first.
#pragma once

#include <memory>

#include "render/fields/blending_field.h"
#include "render/fields/loop_subdivision.h"
#include "render/scene/scene.h"

namespace ulf::render {

// Weights are linear over a triangle.
struct FieldMesh {
  int level = 0;                                // of subdivision
  std::vector<Eigen::Vector3d> positions = {};  // in world; the viewpoint mesh's vertices first
  std::vector<SparseWeights> weights = {};      // of each vertex over the viewpoint mesh's vertices
  std::vector<int> extends = {};                // of a vertex of the extension: its rim vertex; else -1
  std::vector<Triangle> triangles = {};         // the extension's strips first
  std::vector<double> confidence = {};          // of each triangle
  std::size_t strips = 0;                       // the number of triangles of the extension
};

FieldMesh MakeFieldMesh(const ViewpointMesh& mesh, int level,
                        SubdivisionRules rules = SubdivisionRules::kDelaunay);

// The field mesh as seen from one place.
struct PlacedMesh {
  Eigen::Vector3d virtual_center_in_world;  // V, moved off the mesh where it stood on it
  std::vector<Eigen::Matrix3d> corners;     // columns: s (v_k - V), in world axes
  std::vector<Eigen::Matrix3d>
      cone_from_ray;                // inverse of corners; zero where V lies in the triangle's plane
  std::vector<int> view_of_vertex;  // of each vertex of the viewpoint mesh, for V's distance
};

class MeshField : public BlendingField {
 public:
  MeshField(std::shared_ptr<const RenderScene> scene, int level,
            SubdivisionRules rules = SubdivisionRules::kDelaunay);
  std::unique_ptr<FieldFromHere> From(const Eigen::Vector3d& virtual_center_in_world) const override;

  PlacedMesh Place(const Eigen::Vector3d& virtual_center_in_world) const;
  const FieldMesh& field_mesh() const { return *mesh_; }
  const Eigen::Vector3d& center_in_world() const { return scene_->mesh.center_in_world; }

 private:
  Eigen::Vector3d OffTheMesh(const Eigen::Vector3d& virtual_center_in_world) const;

  std::shared_ptr<const RenderScene> scene_;
  std::vector<Eigen::Vector3d> centers_;
  std::shared_ptr<const FieldMesh> mesh_;             // shared with the results of From()
  std::vector<Eigen::Matrix3d> cone_from_direction_;  // of each triangle, from the subject's centre
};

// V stands on the mesh when it is nearer to it than this share of the triangle's shortest edge; it is then
// moved off to this distance. Guessed.
inline constexpr double kOnMeshShare = 1e-3;

}  // namespace ulf::render
