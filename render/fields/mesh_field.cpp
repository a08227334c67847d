#include "render/fields/mesh_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/at.h"
#include "render/fields/ray_cone.h"

namespace ulf::render {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d CornersFrom(const FieldMesh& mesh, const Triangle& t, const Vector3d& origin) {
  Matrix3d corners;
  for (int k = 0; k < 3; ++k) corners.col(k) = mesh.positions[At(t[At(k)])] - origin;
  return corners;
}

class MeshFieldFromHere : public PlacedField {
 public:
  MeshFieldFromHere(std::shared_ptr<const FieldMesh> mesh, PlacedMesh placed)
      : mesh_(std::move(mesh)), placed_(std::move(placed)) {}

  std::vector<int> CandidatesInCone(const Vector3d& axis, double half_angle) const override {
    return ConesThatMayMeet(placed_.cone_from_ray, axis, half_angle);
  }

  void Weights(const RayQuery& query, FieldSample& sample) const override {
    sample.weights.clear();
    sample.confidence = 0;
    sample.extrapolated = false;
    const std::size_t count = query.candidates ? query.candidates->size() : mesh_->triangles.size();
    for (std::size_t i = count; i-- > 0;) {
      const std::size_t t = query.candidates ? At((*query.candidates)[i]) : i;
      const auto barycentric = Barycentric(placed_.cone_from_ray[t], query.ray_in_world);
      if (!barycentric) continue;
      for (int k = 0; k < 3; ++k)
        for (const auto& [vertex, weight] : mesh_->weights[At(mesh_->triangles[t][At(k)])])
          sample.Add(placed_.view_of_vertex[At(vertex)], (*barycentric)(k)*weight);
      sample.confidence = mesh_->confidence[t];
      sample.extrapolated = t < mesh_->strips;
      return;
    }
  }

 private:
  std::shared_ptr<const FieldMesh> mesh_;
  PlacedMesh placed_;
};

}  // namespace

FieldMesh MakeFieldMesh(const ViewpointMesh& mesh, int level, SubdivisionRules rules) {
  std::vector<Vector3d> positions, outward;
  for (const ViewpointMesh::Vertex& vertex : mesh.vertices) {
    positions.push_back(vertex.position_in_world);
    outward.push_back(vertex.outward_in_world);
  }
  const SubdividedMesh fine = SubdivideWeights(positions, outward, mesh.triangles, level, rules);

  FieldMesh result{.level = level, .positions = fine.positions, .weights = fine.weights};
  const TriangleTopology topology = MakeTopology(static_cast<int>(fine.positions.size()), fine.triangles);
  result.extends.assign(fine.positions.size(), -1);
  std::vector<int> virtual_of(fine.positions.size(), -1);
  const auto virtual_vertex = [&](int vertex) {
    int& twin = virtual_of[At(vertex)];
    if (twin < 0) {
      twin = static_cast<int>(result.positions.size());
      result.positions.push_back(fine.positions[At(vertex)] + fine.outward[At(vertex)]);
      result.weights.push_back(fine.weights[At(vertex)]);
      result.extends.push_back(vertex);
    }
    return twin;
  };
  for (const MeshEdge& edge : topology.edges) {
    if (!edge.OnBoundary()) continue;
    const int from_twin = virtual_vertex(edge.from), to_twin = virtual_vertex(edge.to);
    result.triangles.push_back({edge.to, edge.from, from_twin});
    result.triangles.push_back({edge.to, from_twin, to_twin});
  }
  result.strips = result.triangles.size();
  result.confidence.assign(result.strips, kExtrapolatedConfidence);
  result.triangles.insert(result.triangles.end(), fine.triangles.begin(), fine.triangles.end());
  for (const int parent : fine.parent) result.confidence.push_back(mesh.confidence[At(parent)]);
  return result;
}

MeshField::MeshField(std::shared_ptr<const RenderScene> scene, int level, SubdivisionRules rules)
    : scene_(std::move(scene)),
      centers_(scene_->Centers()),
      mesh_(std::make_shared<FieldMesh>(MakeFieldMesh(scene_->mesh, level, rules))) {
  for (const Triangle& t : mesh_->triangles)
    cone_from_direction_.push_back(ConeFromRay(CornersFrom(*mesh_, t, scene_->mesh.center_in_world)));
}

Vector3d MeshField::MovedOffMesh(const Vector3d& virtual_center) const {
  const Vector3d arm = virtual_center - scene_->mesh.center_in_world;
  if (arm.isZero(0)) return virtual_center;
  const Vector3d radial = arm.normalized();
  for (std::size_t t = mesh_->triangles.size(); t-- > 0;) {
    if (!Barycentric(cone_from_direction_[t], radial)) continue;
    const Matrix3d corners = CornersFrom(*mesh_, mesh_->triangles[t], virtual_center);
    const Vector3d first = corners.col(1) - corners.col(0), second = corners.col(2) - corners.col(1);
    const Vector3d third = corners.col(0) - corners.col(2);
    const Vector3d normal = first.cross(-third).normalized();
    const double margin = kOnMeshShare * std::min({first.norm(), second.norm(), third.norm()});
    const double outside = -normal.dot(corners.col(0));
    const double slope = normal.dot(radial);
    if (std::abs(outside) >= margin || slope <= 0) return virtual_center;
    // On a recorded viewpoint rounding decides the side, but both sides give the same picture.
    return virtual_center + radial * ((outside < 0 ? -margin : margin) - outside) / slope;
  }
  return virtual_center;
}

PlacedMesh MeshField::Place(const Vector3d& virtual_center) const {
  PlacedMesh placed;
  placed.virtual_center_in_world = MovedOffMesh(virtual_center);
  placed.corners.reserve(mesh_->triangles.size());
  placed.cone_from_ray.reserve(mesh_->triangles.size());
  for (const Triangle& t : mesh_->triangles) {
    Matrix3d corners = CornersFrom(*mesh_, t, placed.virtual_center_in_world);
    // Outward normals: the determinant is negative when V is outside the triangle's plane.
    if (corners.determinant() > 0) corners = -corners;
    placed.cone_from_ray.push_back(ConeFromRay(corners));
    placed.corners.push_back(corners);
  }
  const double distance = (virtual_center - scene_->mesh.center_in_world).norm();
  for (std::size_t vertex = 0; vertex < scene_->mesh.vertices.size(); ++vertex)
    placed.view_of_vertex.push_back(scene_->mesh.ViewAt(static_cast<int>(vertex), distance, centers_));
  return placed;
}

std::unique_ptr<PlacedField> MeshField::From(const Vector3d& virtual_center) const {
  return std::make_unique<MeshFieldFromHere>(mesh_, Place(virtual_center));
}

}  // namespace ulf::render
