// Weights views by where a pixel's line of sight crosses the viewpoint mesh: the line through the virtual
// camera's centre V along the ray, on the sheet that it enters from outside (ray . outward normal < 0).
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
// Outside the hull, strips extend the boundary outward; their weights are the boundary's. If triangles
// overlap (strips across a concave rim, or a remaining fold), the last one counts; strips come first.
#pragma once

#include <memory>

#include "render/fields/blending_field.h"
#include "render/fields/loop_subdivision.h"
#include "render/scene/scene.h"

namespace ulf::render {

// The subdivided viewpoint mesh and its extension, with weights at the vertices, linear over a triangle.
struct FieldMesh {
  int level = 0;                                // subdivision level
  std::vector<Eigen::Vector3d> positions = {};  // in world; the viewpoint mesh's vertices first
  std::vector<SparseWeights> weights = {};      // per vertex: weights of the viewpoint mesh's vertices
  std::vector<int> extends = {};                // per vertex of the extension: its rim vertex; else -1
  std::vector<Triangle> triangles = {};         // the extension's strips first
  std::vector<double> confidence = {};          // per triangle
  std::size_t strips = 0;                       // the number of triangles of the extension
};

FieldMesh MakeFieldMesh(const ViewpointMesh& mesh, int level,
                        SubdivisionRules rules = SubdivisionRules::kDelaunay);

// The field mesh relative to one virtual camera centre.
struct PlacedMesh {
  Eigen::Vector3d virtual_center_in_world;     // V, moved off the mesh if it lay on it
  std::vector<Eigen::Matrix3d> corners;        // columns: s (v_k - V), in world axes
  std::vector<Eigen::Matrix3d> cone_from_ray;  // inverse of corners; zero if V lies in the triangle's plane
  std::vector<int> view_of_vertex;             // per vertex of the viewpoint mesh: ViewAt() V's distance
};

class MeshField : public BlendingField {
 public:
  MeshField(std::shared_ptr<const RenderScene> scene, int level,
            SubdivisionRules rules = SubdivisionRules::kDelaunay);
  std::unique_ptr<PlacedField> From(const Eigen::Vector3d& virtual_center_in_world) const override;

  PlacedMesh Place(const Eigen::Vector3d& virtual_center_in_world) const;
  const FieldMesh& field_mesh() const { return *mesh_; }
  const Eigen::Vector3d& center_in_world() const { return scene_->mesh.center_in_world; }  // the subject's

 private:
  Eigen::Vector3d MovedOffMesh(const Eigen::Vector3d& virtual_center_in_world) const;

  std::shared_ptr<const RenderScene> scene_;
  std::vector<Eigen::Vector3d> centers_;
  std::shared_ptr<const FieldMesh> mesh_;             // shared with the results of From()
  std::vector<Eigen::Matrix3d> cone_from_direction_;  // per triangle, from the subject's centre
};

// V counts as on the mesh if its distance from a triangle's plane is below this share of the triangle's
// shortest edge; it is then moved to this distance. Guessed.
inline constexpr double kOnMeshShare = 1e-3;

}  // namespace ulf::render
