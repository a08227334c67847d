#include "render/fields/aperture_field.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/at.h"
#include "render/fields/ray_cone.h"

namespace ulf::render {
namespace {

// Outlines shrink if the cosine between a view's outward direction and the direction to the camera is
// smaller. Guessed.
constexpr double kFacingCosine = 0.2;
// `share` over the largest relative growth of a ring: how fast the rings replace the ordinary field.
// Guessed.
constexpr double kShareOfStretch = 10;

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A ring in the camera's own plane is seen edge-on: it is moved off the plane by this share of its outline.
constexpr double kOffPlaneShare = 1e-6;

// Returns the number of edges from a vertex at which its weight has become zero: every level doubles the
// reach of Loop's rules and adds two edges.
int BoundaryDistance(int level) { return (2 << level) - 1; }

std::vector<std::vector<int>> Neighbours(const FieldMesh& mesh) {
  std::vector<std::vector<int>> neighbours(mesh.positions.size());
  for (std::size_t t = mesh.strips; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = mesh.triangles[t][k], to = mesh.triangles[t][(k + 1) % 3];
      neighbours[At(from)].push_back(to);
      neighbours[At(to)].push_back(from);
    }
  return neighbours;
}

// Returns distances in edges from `start`, of all vertices no farther away than `most`.
std::map<int, int> Distances(const std::vector<std::vector<int>>& neighbours, int start, int most) {
  std::map<int, int> distances{{start, 0}};
  std::vector<int> front{start}, next;
  for (int distance = 1; distance <= most; ++distance, front.swap(next)) {
    next.clear();
    for (const int vertex : front)
      for (const int neighbour : neighbours[At(vertex)])
        if (distances.emplace(neighbour, distance).second) next.push_back(neighbour);
  }
  return distances;
}

// Returns the radius of a view's outline.
double OutlineRadius(const Vector3d& view_in_cam, const Vector3d& outward_in_cam, double focus_depth,
                     double radius, double facing_cosine) {
  const double facing = std::clamp(-outward_in_cam.z() / facing_cosine, 0.0, 1.0);
  return radius * std::max(0.0, 1 - view_in_cam.z() / focus_depth) * facing;
}

}  // namespace

// The vertices relative to the camera's centre, in its axes.
struct ApertureField::WarpedVertices {
  std::vector<Vector3d> positions;
  double stretch = 1;  // the largest ratio of the distances from the view after and before
};

ApertureField::ApertureField(std::shared_ptr<const MeshField> field) : field_(std::move(field)) {
  MakeRings();
}

void ApertureField::MakeRings() {
  const FieldMesh& mesh = field_->field_mesh();
  const auto neighbours = Neighbours(mesh);
  const int boundary = BoundaryDistance(mesh.level);
  int views = 0;
  for (const SparseWeights& weights : mesh.weights)
    for (const auto& [vertex, weight] : weights) views = std::max(views, vertex + 1);
  rings_.resize(At(views));

  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::map<int, Vector3d> weights_of;
    for (std::size_t k = 0; k < 3; ++k)
      for (const auto& [vertex, weight] : mesh.weights[At(mesh.triangles[t][k])])
        weights_of.try_emplace(vertex, Vector3d::Zero()).first->second(static_cast<Eigen::Index>(k)) +=
            weight;
    for (const auto& [vertex, weights] : weights_of)
      rings_[At(vertex)].parts.push_back({static_cast<int>(t), mesh.triangles[t], weights});
  }
  for (std::size_t r = 0; r < rings_.size(); ++r) {
    Ring& ring = rings_[r];
    const std::map<int, int> distances = Distances(neighbours, static_cast<int>(r), boundary);
    std::map<int, int> local;
    const auto local_index = [&](const auto& self, int vertex) -> int {
      const int rim = mesh.extends[At(vertex)];
      const int local_rim = rim >= 0 ? self(self, rim) : -1;
      const auto [found, is_new] = local.emplace(vertex, static_cast<int>(ring.vertices.size()));
      if (is_new) {
        const auto distance = distances.find(vertex);
        ring.vertices.push_back(vertex);
        ring.extends.push_back(local_rim);
        ring.shares.push_back(distance == distances.end() ? 1.0
                                                          : static_cast<double>(distance->second) / boundary);
      }
      return found->second;
    };
    for (Part& part : ring.parts)
      for (int& corner : part.corners) corner = local_index(local_index, corner);
  }
}

ApertureField::WarpedVertices ApertureField::WarpVertices(std::size_t r, const PlacedMesh& placed,
                                                          const Rigid3& cam_from_world,
                                                          const Aperture& aperture) const {
  const Ring& ring = rings_[r];
  const FieldMesh& mesh = field_->field_mesh();
  const auto in_camera = [&](int vertex) -> Vector3d {
    return cam_from_world.rotation * (mesh.positions[At(vertex)] - placed.virtual_center_in_world);
  };
  const Vector3d view = in_camera(static_cast<int>(r));
  const Vector3d outward =
      cam_from_world.rotation * (mesh.positions[r] - field_->center_in_world()).normalized();
  const double outline =
      OutlineRadius(view, outward, FocusDepth(aperture, cam_from_world), aperture.radius, kFacingCosine);

  WarpedVertices warped;
  for (std::size_t i = 0; i < ring.vertices.size(); ++i) {
    Vector3d position = in_camera(ring.vertices[i]);
    if (const int rim = ring.extends[i]; rim >= 0) {
      position += warped.positions[At(rim)] - in_camera(ring.vertices[At(rim)]);
    } else {
      const Vector2d away = (position - view).head<2>();
      const double distance = away.norm(), wanted = outline * ring.shares[i];
      constexpr double kLeastShare = 1e-9;  // a vertex nearer to the view has no direction to move in
      if (distance < wanted && distance > kLeastShare * wanted) {
        const double kept = distance / wanted;
        warped.stretch = std::max(warped.stretch, 1 / kept);
        position.head<2>() = view.head<2>() + away / kept;
        position.z() = view.z() + (position.z() - view.z()) * kept;
      }
    }
    warped.positions.push_back(position);
  }
  if (const double least = kOffPlaneShare * outline; warped.stretch > 1 && std::abs(view.z()) < least)
    for (Vector3d& position : warped.positions) position.z() += std::copysign(least, view.z());
  return warped;
}

WarpedRings ApertureField::Warp(const PlacedMesh& placed, const Rigid3& cam_from_world,
                                const Aperture& aperture) const {
  WarpedRings rings;
  for (std::size_t r = 0; r < rings_.size(); ++r) {
    const WarpedVertices vertices = WarpVertices(r, placed, cam_from_world, aperture);
    rings.share = std::max(rings.share, kShareOfStretch * (vertices.stretch - 1));
    for (const Part& part : rings_[r].parts) {
      WarpedTriangle warped{.triangle = part.triangle,
                            .vertex = static_cast<int>(r),
                            .weights = part.weights,
                            .corners = {},
                            .cone_from_ray = {}};
      for (int k = 0; k < 3; ++k) warped.corners.col(k) = vertices.positions[At(part.corners[At(k)])];
      if (warped.corners.determinant() > 0) warped.corners = -warped.corners;
      warped.cone_from_ray = ConeFromRay(warped.corners);
      if (!warped.cone_from_ray.isZero(0)) rings.triangles.push_back(warped);
    }
  }
  return rings;
}

namespace {

class ApertureFieldFromHere : public PlacedField {
 public:
  ApertureFieldFromHere(std::shared_ptr<const MeshField> field, std::unique_ptr<PlacedField> ordinary,
                        std::vector<int> view_of_vertex, WarpedRings rings,
                        const Eigen::Quaterniond& cam_from_world)
      : field_(std::move(field)),
        ordinary_(std::move(ordinary)),
        view_of_vertex_(std::move(view_of_vertex)),
        rings_(std::move(rings)),
        cam_from_world_(cam_from_world) {}

  // Returns triangles of the rings. The ordinary field finds its own.
  std::vector<int> CandidatesInCone(const Vector3d& axis, double half_angle) const override {
    std::vector<int> candidates;
    const Vector3d axis_in_cam = cam_from_world_ * axis;
    for (std::size_t i = 0; i < rings_.triangles.size(); ++i)
      if (MayMeet(rings_.triangles[i].cone_from_ray, axis_in_cam, half_angle))
        candidates.push_back(static_cast<int>(i));
    return candidates;
  }

  void Weights(const RayQuery& query, FieldSample& sample) const override {
    ordinary_->Weights({query.ray_in_world, query.point_in_world, nullptr}, sample);
    std::map<int, double> weight_of;
    double total = 0;
    for (const auto& [view, weight] : sample.weights) {
      weight_of[view] = weight;
      total += weight;
    }
    double confidence = total * sample.confidence;
    const Vector3d ray_in_cam = cam_from_world_ * query.ray_in_world;
    const std::size_t count = query.candidates ? query.candidates->size() : rings_.triangles.size();
    for (std::size_t n = 0; n < count; ++n) {
      const WarpedTriangle& part = rings_.triangles[query.candidates ? At((*query.candidates)[n]) : n];
      const auto barycentric = Barycentric(part.cone_from_ray, ray_in_cam);
      if (!barycentric) continue;
      const double weight = rings_.share * barycentric->dot(part.weights);
      if (!(weight > 0)) continue;
      total += weight;
      confidence += weight * field_->field_mesh().confidence[At(part.triangle)];
      weight_of[view_of_vertex_[At(part.vertex)]] += weight;
    }
    sample.weights.clear();
    sample.confidence = 0;
    if (total < kLeastWeightOfField) return;
    for (const auto& [view, weight] : weight_of) sample.weights.push_back({view, weight / total});
    sample.confidence = confidence / total;
  }

 private:
  std::shared_ptr<const MeshField> field_;
  std::unique_ptr<PlacedField> ordinary_;
  std::vector<int> view_of_vertex_;
  WarpedRings rings_;
  Eigen::Quaterniond cam_from_world_;
};

}  // namespace

std::unique_ptr<PlacedField> ApertureField::From(const Rigid3& cam_from_world,
                                                 const Aperture& aperture) const {
  const Vector3d virtual_center = cam_from_world.OriginInSource();
  const PlacedMesh placed = field_->Place(virtual_center);
  WarpedRings rings = Warp(placed, cam_from_world, aperture);
  auto ordinary = field_->From(virtual_center);
  if (rings.share == 0) return ordinary;
  return std::make_unique<ApertureFieldFromHere>(field_, std::move(ordinary), placed.view_of_vertex,
                                                 std::move(rings), cam_from_world.rotation);
}

}  // namespace ulf::render
