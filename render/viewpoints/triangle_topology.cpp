#include "render/viewpoints/triangle_topology.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/base/at.h"

namespace ulf::render {

TriangleTopology MakeTopology(int vertex_count, const std::vector<Triangle>& triangles) {
  TriangleTopology topology;
  topology.edges_of_triangle.resize(triangles.size());
  topology.neighbours.resize(At(vertex_count));
  topology.boundary_neighbours.assign(At(vertex_count), {-1, -1});

  std::map<std::pair<int, int>, int> edge_of_pair;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = triangles[t][k], to = triangles[t][(k + 1) % 3], opposite = triangles[t][(k + 2) % 3];
      const auto [entry, is_new] =
          edge_of_pair.try_emplace(std::minmax(from, to), static_cast<int>(topology.edges.size()));
      if (is_new) topology.edges.push_back({.from = from, .to = to});
      MeshEdge& edge = topology.edges[At(entry->second)];
      const std::size_t side = is_new ? 0 : 1;
      edge.triangle[side] = static_cast<int>(t);
      edge.opposite[side] = opposite;
      topology.edges_of_triangle[t][k] = entry->second;
    }
  }
  for (const MeshEdge& edge : topology.edges) {
    topology.neighbours[At(edge.from)].push_back(edge.to);
    topology.neighbours[At(edge.to)].push_back(edge.from);
    if (!edge.OnBoundary()) continue;
    topology.boundary_neighbours[At(edge.from)][1] = edge.to;
    topology.boundary_neighbours[At(edge.to)][0] = edge.from;
  }
  for (std::vector<int>& ring : topology.neighbours) std::ranges::sort(ring);
  return topology;
}

std::vector<int> SplitPinches(int vertex_count, std::vector<Triangle>& triangles) {
  std::vector<std::vector<int>> triangles_at(At(vertex_count));
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int vertex : triangles[t]) triangles_at[At(vertex)].push_back(static_cast<int>(t));

  std::vector<int> repeated;
  for (int vertex = 0; vertex < vertex_count; ++vertex) {
    std::vector<int> left = triangles_at[At(vertex)];
    bool first_fan = true;
    while (!left.empty()) {
      // One fan: triangles at this vertex that share another corner.
      std::vector<int> fan{left.back()};
      left.pop_back();
      for (std::size_t i = 0; i < fan.size(); ++i) {
        const Triangle& inside = triangles[At(fan[i])];
        const auto touches = [&](int other) {
          return std::ranges::any_of(inside, [&](int corner) {
            const Triangle& candidate = triangles[At(other)];
            return corner != vertex && std::ranges::count(candidate, corner) > 0;
          });
        };
        const auto rest = std::stable_partition(left.begin(), left.end(), [&](int t) { return !touches(t); });
        fan.insert(fan.end(), rest, left.end());
        left.erase(rest, left.end());
      }
      if (!first_fan) {
        const int added = vertex_count + static_cast<int>(repeated.size());
        repeated.push_back(vertex);
        for (const int t : fan) std::replace(triangles[At(t)].begin(), triangles[At(t)].end(), vertex, added);
      }
      first_fan = false;
    }
  }
  return repeated;
}

}  // namespace ulf::render
