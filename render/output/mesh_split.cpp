#include "render/output/mesh_split.h"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace ulf::render {
namespace {

using Eigen::Vector3d;

std::uint64_t EdgeKey(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

// Numbers of the new vertices in the middle of the edges that are too long.
std::unordered_map<std::uint64_t, std::uint32_t> SplitEdges(TriangleMesh& mesh,
                                                            const std::vector<Vector3d>& view_centers,
                                                            double most_slope) {
  std::unordered_map<std::uint64_t, std::uint32_t> middles;
  std::unordered_map<std::uint64_t, bool> looked_at;
  for (const auto& triangle : mesh.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = triangle[c], b = triangle[(c + 1) % 3];
      if (!looked_at.try_emplace(EdgeKey(a, b), true).second) continue;
      const Eigen::Vector3f middle = 0.5f * (mesh.vertices[a] + mesh.vertices[b]);
      const double length = (mesh.vertices[a] - mesh.vertices[b]).norm();
      const bool is_long = std::ranges::any_of(view_centers, [&](const Vector3d& center) {
        return length > most_slope * (center - middle.cast<double>()).norm();
      });
      if (!is_long) continue;
      middles[EdgeKey(a, b)] = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(middle);
    }
  return middles;
}

// One triangle by which of its edges have a middle.
void AppendParts(const std::array<std::uint32_t, 3>& triangle,
                 const std::unordered_map<std::uint64_t, std::uint32_t>& middles,
                 std::vector<std::array<std::uint32_t, 3>>& parts) {
  constexpr std::uint32_t kWhole = static_cast<std::uint32_t>(-1);
  std::array<std::uint32_t, 3> corner = triangle, middle{};  // of the edge that begins there
  const auto find = [&] {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto found = middles.find(EdgeKey(corner[c], corner[(c + 1) % 3]));
      middle[c] = found == middles.end() ? kWhole : found->second;
    }
  };
  find();
  const auto split = std::ranges::count_if(middle, [](std::uint32_t at) { return at != kWhole; });
  // The edge that is alone in being split, or in being whole, comes first.
  for (int turn = 0; turn < 2 && (split == 1 || split == 2) && (middle[0] != kWhole) != (split == 1);
       ++turn) {
    std::rotate(corner.begin(), corner.begin() + 1, corner.end());
    find();
  }
  const auto& [a, b, c] = corner;
  if (split == 0) {
    parts.push_back(corner);
  } else if (split == 1) {
    parts.push_back({a, middle[0], c});
    parts.push_back({middle[0], b, c});
  } else if (split == 2) {
    parts.push_back({a, b, middle[1]});
    parts.push_back({a, middle[1], middle[2]});
    parts.push_back({middle[2], middle[1], c});
  } else {
    parts.push_back({a, middle[0], middle[2]});
    parts.push_back({middle[0], b, middle[1]});
    parts.push_back({middle[2], middle[1], c});
    parts.push_back({middle[0], middle[1], middle[2]});
  }
}

}  // namespace

TriangleMesh Split(const TriangleMesh& mesh, const std::vector<Vector3d>& view_centers, double most_slope,
                   std::size_t most_triangles) {
  TriangleMesh fine = mesh;
  while (fine.triangles.size() < most_triangles) {
    const auto middles = SplitEdges(fine, view_centers, most_slope);
    if (middles.empty()) break;
    std::vector<std::array<std::uint32_t, 3>> parts;
    for (const auto& triangle : fine.triangles) AppendParts(triangle, middles, parts);
    fine.triangles = std::move(parts);
  }
  return fine;
}

}  // namespace ulf::render
