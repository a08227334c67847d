#include "render/fields/limit_surface.h"

#include <algorithm>
#include <utility>

#include "core/base/at.h"
#include "render/fields/weight_sum.h"

namespace ulf::render {
namespace {

using Eigen::Vector3d;
using OppositeOfEdge = std::map<std::pair<int, int>, int>;

// After as many levels nothing is left of a triangle but its corner: the slowest share that a level keeps of a
// difference around a vertex is 5/8 (of any valence), and 0.625^80 is 5e-17.
constexpr int kMostRings = 80;

// Of each directed edge the third corner of its triangle.
OppositeOfEdge OppositesOf(const std::vector<Triangle>& triangles) {
  OppositeOfEdge opposite;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) opposite[{t[k], t[(k + 1) % 3]}] = t[(k + 2) % 3];
  return opposite;
}

// The neighbours of a vertex, counter-clockwise; on the rim from one end to the other.
std::vector<int> FanAround(int vertex, const TriangleTopology& topology, const OppositeOfEdge& opposite) {
  std::vector<int> fan;
  const std::vector<int>& neighbours = topology.neighbours[At(vertex)];
  if (neighbours.empty()) return fan;
  int next = topology.OnBoundary(vertex) ? topology.boundary_neighbours[At(vertex)][1] : neighbours.front();
  while (fan.size() < neighbours.size()) {
    fan.push_back(next);
    const auto found = opposite.find({vertex, next});
    if (found == opposite.end()) break;
    next = found->second;
  }
  return fan;
}

// A vertex and its neighbours, as a mesh: the vertex is 0, its neighbours are 1, 2, ...
std::vector<Triangle> FanTriangles(int sectors, bool on_rim) {
  std::vector<Triangle> triangles;
  for (int i = 0; i < sectors; ++i) triangles.push_back({0, i + 1, !on_rim && i + 1 == sectors ? 1 : i + 2});
  return triangles;
}

// A mesh whose vertices weigh themselves. Places do not matter.
SubdividedMesh WithoutPlaces(const std::vector<Triangle>& triangles, int vertex_count) {
  SubdividedMesh mesh;
  mesh.positions.assign(At(vertex_count), Vector3d::Zero());
  mesh.outward = mesh.positions;
  mesh.triangles = triangles;
  mesh.parent.assign(triangles.size(), 0);
  for (int vertex = 0; vertex < vertex_count; ++vertex) mesh.weights.push_back({{vertex, 1.0}});
  return mesh;
}

template <typename Controls>
Controls Over(const Controls& controls, const std::vector<SparseWeights>& weights) {
  Controls over;
  WeightSum sum;
  for (std::size_t i = 0; i < controls.size(); ++i) {
    for (const auto& [vertex, factor] : controls[i]) sum.Add(weights[At(vertex)], factor);
    over[i] = sum.Take();
  }
  return over;
}

template <typename Controls>
void AddBoxSpline(const Controls& controls, const Vector3d& barycentric, WeightSum& sum) {
  const auto weights = BoxSplineWeights(barycentric);
  for (std::size_t i = 0; i < controls.size(); ++i) sum.Add(controls[i], weights[i]);
}

}  // namespace

PlaceOnCorner FirstLevelPlace(const Vector3d& b) {
  for (int k = 0; k < 3; ++k) {
    if (b(k) < 0.5) continue;
    // From the small coordinates, so that doubling again and again does not double what rounding left.
    const double next = 2 * b((k + 1) % 3), last = 2 * b((k + 2) % 3);
    return {k, {1 - next - last, next, last}};
  }
  return {3, {1 - 2 * b.z(), 1 - 2 * b.x(), 1 - 2 * b.y()}};
}

// The twelve vertices of box_spline.h around a triangle with regular corners, over the mesh's vertices.
LimitSurface::Controls LimitSurface::ControlsOf(const Triangle& of, const OppositeOfEdge& opposite) {
  WeightSum sum;
  const auto phantom = [&](const SparseWeights& a, const SparseWeights& b, const SparseWeights& c) {
    sum.Add(a, 1);
    sum.Add(b, 1);
    sum.Add(c, -1);
    return sum.Take();
  };
  // The third corner of the triangle at the edge from a to b, nothing where there is none.
  const auto third = [&](const SparseWeights& a, const SparseWeights& b) -> SparseWeights {
    const auto found = opposite.find({a.front().first, b.front().first});
    if (found == opposite.end()) return {};
    return {{found->second, 1.0}};
  };
  Controls controls;
  for (std::size_t k = 0; k < 3; ++k) controls[k] = {{of[k], 1.0}};
  std::array<bool, 3> on_rim{};  // the edge from corner k to the next
  for (std::size_t k = 0; k < 3; ++k) {
    const SparseWeights &from = controls[k], &to = controls[(k + 1) % 3];
    controls[3 + k] = third(to, from);
    on_rim[k] = controls[3 + k].empty();
    if (on_rim[k]) controls[3 + k] = phantom(from, to, controls[(k + 2) % 3]);
  }
  constexpr std::array<std::size_t, 3> kBesideNext{6, 8, 9}, kBesideLast{7, 11, 10};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3, last = (k + 2) % 3;
    const SparseWeights &corner = controls[k], &beyond_next = controls[3 + k],
                        &beyond_last = controls[3 + last];
    SparseWeights &beside_next = controls[kBesideNext[k]], &beside_last = controls[kBesideLast[k]];
    if (!on_rim[k]) {
      beside_next = third(beyond_next, corner);
      if (beside_next.empty()) beside_next = phantom(corner, beyond_next, controls[next]);
    }
    if (!on_rim[last]) {
      beside_last = third(corner, beyond_last);
      if (beside_last.empty()) beside_last = phantom(corner, beyond_last, controls[last]);
    }
    // A regular corner of the rim with an edge of the rim here has its other one beyond the other edge.
    if (on_rim[k]) beside_next = phantom(corner, beside_last, beyond_last);
    if (on_rim[last]) beside_last = phantom(corner, beside_next, beyond_next);
  }
  return controls;
}

LimitSurface::Star LimitSurface::MakeStar(int sectors, bool on_rim, SubdivisionRules rules) {
  const int neighbours = sectors + (on_rim ? 1 : 0);
  const auto fan = WithoutPlaces(FanTriangles(sectors, on_rim), neighbours + 1);
  const std::vector<Triangle> small = SubdivideOnce(fan, rules, false).triangles;
  int vertices = 0;
  for (const Triangle& t : small) vertices = std::max({vertices, t[0] + 1, t[1] + 1, t[2] + 1});
  // At the edge of the star a level is wrong, because the mesh goes on there. Nothing below reads that.
  const SubdividedMesh fine = SubdivideOnce(WithoutPlaces(small, vertices), rules, false);
  const OppositeOfEdge opposite = OppositesOf(fine.triangles);
  Star star;
  star.next.resize(At(vertices));
  star.next[0] = fine.weights[0];
  for (int sector = 0; sector < sectors; ++sector) {
    // Four small triangles for each of the fan, four of the next level for each of these.
    const Triangle& inner = small[At(4 * sector)];  // hub, two midpoints
    const Triangle& far = small[At(4 * sector + 3)];
    const Triangle& next_inner = fine.triangles[At(16 * sector)];
    const Triangle& next_middle = fine.triangles[At(16 * sector + 3)];
    const Triangle& from = fan.triangles[At(sector)];
    for (std::size_t side : {1u, 2u}) {
      star.next[At(inner[side])] = fine.weights[At(next_inner[side])];
      star.next[At(from[side])] = fine.weights[At(inner[side])];
    }
    star.next[At(far[1])] = fine.weights[At(next_middle[1])];
    auto& patches = star.patches.emplace_back();
    for (int part = 0; part < 3; ++part)
      patches[At(part)] =
          Over(ControlsOf(fine.triangles[At(16 * sector + 1 + part)], opposite), fine.weights);
  }
  WeightSum sum;
  const int first_midpoint = small.front()[1], last_midpoint = small[At(4 * (sectors - 1))][2];
  if (!on_rim) {
    const double share = sectors == 3 ? 1.0 / 5 : 1.0 / (2 * sectors);
    sum.Add(0, 1 - sectors * share);
    for (int sector = 0; sector < sectors; ++sector) sum.Add(small[At(4 * sector)][1], share);
  } else {
    const double share = rules == SubdivisionRules::kLoop ? 1.0 / 6 : 0;
    sum.Add(0, 1 - 2 * share);
    sum.Add(first_midpoint, share);
    sum.Add(last_midpoint, share);
  }
  star.limit = sum.Take();
  return star;
}

LimitSurface::LimitSurface(const std::vector<Vector3d>& positions, const std::vector<Triangle>& triangles,
                           SubdivisionRules rules)
    : triangles_(triangles) {
  const int vertex_count = static_cast<int>(positions.size());
  const SubdividedMesh first = SubdivideWeights(
      positions, std::vector<Vector3d>(positions.size(), Vector3d::Zero()), triangles, 1, rules);
  weights_ = first.weights;
  const TriangleTopology topology = MakeTopology(vertex_count, triangles);
  const OppositeOfEdge opposite = OppositesOf(triangles), fine_opposite = OppositesOf(first.triangles);
  std::map<std::pair<int, int>, int> midpoint_of;
  for (std::size_t e = 0; e < topology.edges.size(); ++e)
    midpoint_of[std::minmax(topology.edges[e].from, topology.edges[e].to)] =
        vertex_count + static_cast<int>(e);

  // The stars: after the first level, of the fan around each vertex.
  std::vector<const Star*> star_of(positions.size(), nullptr);
  std::vector<std::vector<int>> fans(positions.size());
  star_vertices_.resize(positions.size());
  for (int vertex = 0; vertex < vertex_count; ++vertex) {
    std::vector<int>& fan = fans[At(vertex)];
    fan = FanAround(vertex, topology, opposite);
    const bool on_rim = topology.OnBoundary(vertex);
    const bool is_regular = on_rim ? rules == SubdivisionRules::kLoop && fan.size() == 4 : fan.size() == 6;
    if (is_regular || fan.size() < 2) continue;
    const int sectors = static_cast<int>(fan.size()) - (on_rim ? 1 : 0);
    auto& star = stars_[{sectors, on_rim}];
    if (!star) star = std::make_unique<const Star>(MakeStar(sectors, on_rim, rules));
    star_of[At(vertex)] = star.get();
    std::vector<int>& of_star = star_vertices_[At(vertex)];
    of_star = {vertex};
    of_star.insert(of_star.end(), fan.begin(), fan.end());
    const std::size_t corners = of_star.size();
    for (const MeshEdge& edge : MakeTopology(static_cast<int>(corners), FanTriangles(sectors, on_rim)).edges)
      of_star.push_back(midpoint_of.at(std::minmax(of_star[At(edge.from)], of_star[At(edge.to)])));
  }

  patches_.resize(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Patches& patches = patches_[t];
    patches.middle = Over(ControlsOf(first.triangles[4 * t + 3], fine_opposite), weights_);
    for (std::size_t k = 0; k < 3; ++k) {
      const int hub = triangles[t][k];
      Corner& corner = patches.corners[k];
      corner.star = star_of[At(hub)];
      if (corner.star == nullptr) {
        Triangle small = first.triangles[4 * t + k];  // the hub is its corner k
        std::rotate(small.begin(), small.begin() + static_cast<std::ptrdiff_t>(k), small.end());
        patches.regular[k] = Over(ControlsOf(small, fine_opposite), weights_);
      } else {
        const auto next = std::ranges::find(fans[At(hub)], triangles[t][(k + 1) % 3]);
        corner.sector = static_cast<int>(next - fans[At(hub)].begin());
      }
    }
  }
}

bool LimitSurface::IsRegular(int triangle, int corner) const {
  return patches_[At(triangle)].corners[At(corner)].star == nullptr;
}

SparseWeights LimitSurface::Weights(int triangle, const Vector3d& barycentric) const {
  const PlaceOnCorner place = FirstLevelPlace(barycentric);
  const Patches& patches = patches_[At(triangle)];
  if (place.corner < 3 && !IsRegular(triangle, place.corner))
    return AtStar(patches.corners[At(place.corner)], triangles_[At(triangle)][At(place.corner)],
                  place.barycentric);
  thread_local WeightSum sum;
  AddBoxSpline(place.corner == 3 ? patches.middle : patches.regular[At(place.corner)], place.barycentric,
               sum);
  return sum.Take();
}

SparseWeights LimitSurface::AtStar(const Corner& corner, int hub, const Vector3d& barycentric) const {
  thread_local WeightSum sum;
  const Star& star = *corner.star;
  Vector3d b = barycentric;
  int rings = 0;
  PlaceOnCorner place = FirstLevelPlace(b);
  for (; place.corner == 0 && rings < kMostRings; ++rings) {
    b = place.barycentric;
    place = FirstLevelPlace(b);
  }
  SparseWeights of_star = star.limit;
  if (place.corner != 0) {
    // The small triangles begin with their first corner in the order of the larger one's (SubdivideOnce).
    Vector3d in_small = place.barycentric;
    if (place.corner == 1) in_small = {in_small.z(), in_small.x(), in_small.y()};
    if (place.corner == 2) in_small = {in_small.y(), in_small.z(), in_small.x()};
    AddBoxSpline(star.patches[At(corner.sector)][At(place.corner - 1)], in_small, sum);
    of_star = sum.Take();
    for (; rings > 0; --rings) {
      for (const auto& [vertex, weight] : of_star) sum.Add(star.next[At(vertex)], weight);
      of_star = sum.Take();
    }
  }
  const std::vector<int>& vertices = star_vertices_[At(hub)];
  for (const auto& [vertex, weight] : of_star) sum.Add(weights_[At(vertices[At(vertex)])], weight);
  return sum.Take();
}

}  // namespace ulf::render
