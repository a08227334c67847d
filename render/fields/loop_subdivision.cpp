#include "render/fields/loop_subdivision.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/at.h"
#include "core/geometry/angles.h"

namespace ulf::render {
namespace {

// Adds up sparse weights.
class WeightSum {
 public:
  void Add(int vertex, double weight) {
    if (At(vertex) >= sum_.size()) {
      sum_.resize(At(vertex) + 1, 0.0);
      is_listed_.resize(At(vertex) + 1, 0);
    }
    if (!std::exchange(is_listed_[At(vertex)], std::uint8_t{1})) listed_.push_back(vertex);
    sum_[At(vertex)] += weight;
  }
  void Add(const SparseWeights& weights, double factor) {
    for (const auto& [vertex, weight] : weights) Add(vertex, factor * weight);
  }
  // Returns the sum, in ascending order of vertices, and resets it.
  SparseWeights Take() {
    std::ranges::sort(listed_);
    SparseWeights taken;
    taken.reserve(listed_.size());
    for (const int vertex : listed_) {
      taken.emplace_back(vertex, std::exchange(sum_[At(vertex)], 0.0));
      is_listed_[At(vertex)] = 0;
    }
    listed_.clear();
    return taken;
  }

 private:
  std::vector<double> sum_;  // per vertex, so that adding takes no search
  std::vector<std::uint8_t> is_listed_;
  std::vector<int> listed_;
};

SparseWeights VertexRule(const SubdividedMesh& mesh, const TriangleTopology& topology, int vertex,
                         SubdivisionRules rules, WeightSum& sum) {
  const std::vector<int>& ring = topology.neighbours[At(vertex)];
  if (ring.empty()) return mesh.weights[At(vertex)];
  if (topology.OnBoundary(vertex)) {
    if (rules == SubdivisionRules::kDelaunay) return mesh.weights[At(vertex)];
    sum.Add(mesh.weights[At(vertex)], 3.0 / 4);
    for (const int neighbour : topology.boundary_neighbours[At(vertex)])
      sum.Add(mesh.weights[At(neighbour)], 1.0 / 8);
    return sum.Take();
  }
  const double valence = static_cast<double>(ring.size());
  const double share = ring.size() == 3 ? 3.0 / 16 : 3 / (8 * valence);
  sum.Add(mesh.weights[At(vertex)], 1 - valence * share);
  for (const int neighbour : ring) sum.Add(mesh.weights[At(neighbour)], share);
  return sum.Take();
}

// Returns how ambiguous a Delaunay edge is: 0 in a regular mesh, where the angles that face it sum to 120
// degrees, 1 if its four corners lie on a circle (180 degrees) and the other diagonal is Delaunay's as well.
double Ambiguity(const SubdividedMesh& mesh, const MeshEdge& edge) {
  const Eigen::Vector3d &from = mesh.positions[At(edge.from)], &to = mesh.positions[At(edge.to)];
  double facing = 0;
  for (const int opposite : edge.opposite)
    facing += AngleBetween(from - mesh.positions[At(opposite)], to - mesh.positions[At(opposite)]);
  return std::clamp((facing - 2 * M_PI / 3) / (M_PI / 3), 0.0, 1.0);
}

SparseWeights EdgeRule(const SubdividedMesh& mesh, const MeshEdge& edge, double ambiguity, WeightSum& sum) {
  const double opposite_share = edge.OnBoundary() ? 0 : 0.125 * (1 + ambiguity);
  for (const int end : {edge.from, edge.to}) sum.Add(mesh.weights[At(end)], 0.5 - opposite_share);
  if (!edge.OnBoundary())
    for (const int opposite : edge.opposite) sum.Add(mesh.weights[At(opposite)], opposite_share);
  return sum.Take();
}

// Subdivides once. Vertices stay and the midpoints of edges come after them, in the order of MakeTopology()'s
// edges. Triangle t = (a, b, c) becomes 4 t and the three after it: (a, ab, ca), (ab, b, bc), (ca, bc, c),
// (ab, bc, ca). `is_first` says that the edges are Delaunay's, and kDelaunay's first rule holds.
SubdividedMesh SubdivideOnce(const SubdividedMesh& coarse, SubdivisionRules rules, bool is_first) {
  const bool is_loop = rules == SubdivisionRules::kLoop;
  const int vertex_count = static_cast<int>(coarse.positions.size());
  const TriangleTopology topology = MakeTopology(vertex_count, coarse.triangles);
  WeightSum sum;
  SubdividedMesh fine;
  fine.positions = coarse.positions;
  fine.outward = coarse.outward;
  for (int vertex = 0; vertex < vertex_count; ++vertex)
    fine.weights.push_back(VertexRule(coarse, topology, vertex, rules, sum));
  for (const MeshEdge& edge : topology.edges) {
    fine.positions.push_back(0.5 * (coarse.positions[At(edge.from)] + coarse.positions[At(edge.to)]));
    Eigen::Vector3d outward = Eigen::Vector3d::Zero();
    if (edge.OnBoundary()) outward = 0.5 * (coarse.outward[At(edge.from)] + coarse.outward[At(edge.to)]);
    fine.outward.push_back(outward);
    const bool may_be_ambiguous = is_first && !is_loop && !edge.OnBoundary();
    fine.weights.push_back(EdgeRule(coarse, edge, may_be_ambiguous ? Ambiguity(coarse, edge) : 0, sum));
  }
  for (std::size_t t = 0; t < coarse.triangles.size(); ++t) {
    const auto [a, b, c] = coarse.triangles[t];
    const auto [e0, e1, e2] = topology.edges_of_triangle[t];
    const int ab = vertex_count + e0, bc = vertex_count + e1, ca = vertex_count + e2;
    for (const Triangle& part :
         {Triangle{a, ab, ca}, Triangle{ab, b, bc}, Triangle{ca, bc, c}, Triangle{ab, bc, ca}}) {
      fine.triangles.push_back(part);
      fine.parent.push_back(coarse.parent[t]);
    }
  }
  return fine;
}

}  // namespace

SubdividedMesh SubdivideWeights(const std::vector<Eigen::Vector3d>& positions,
                                const std::vector<Eigen::Vector3d>& outward,
                                const std::vector<Triangle>& triangles, int levels, SubdivisionRules rules) {
  SubdividedMesh mesh{
      .positions = positions, .outward = outward, .weights = {}, .triangles = triangles, .parent = {}};
  for (std::size_t i = 0; i < positions.size(); ++i) mesh.weights.push_back({{static_cast<int>(i), 1.0}});
  for (std::size_t t = 0; t < triangles.size(); ++t) mesh.parent.push_back(static_cast<int>(t));
  for (int level = 0; level < std::min(levels, kFinestLevel); ++level)
    mesh = SubdivideOnce(mesh, rules, level == 0);
  return mesh;
}

}  // namespace ulf::render
