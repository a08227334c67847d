#include "render/proxy/mesh_resolution.h"
#include "core/geometry/small_matrices.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

namespace ulf::render {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Maps to a space in which cells are cubes of one size.
Vector3d Evened(const Vector3d& from_center, double even_within) {
  const double distance = from_center.norm() / even_within;
  if (distance <= 1) return from_center / even_within;
  return from_center / (even_within * distance) * (1 + std::log(distance));
}

struct GridCell {
  Matrix3d quadric = Matrix3d::Zero();  // sum over its triangles' planes, weighted by area
  Vector3d quadric_by_point = Vector3d::Zero();
  Vector3d sum = Vector3d::Zero();
  int points = 0;
  std::uint32_t vertex = 0;
};

// Returns the place nearest to the planes; in directions that they hardly constrain, the mean of the points.
Vector3d PlaceOf(const GridCell& cell, double cell_size) {
  constexpr double kLeastShare =
      1e-2;  // of the largest eigenvalue: below it planes count as parallel. Guessed.
  const Vector3d middle = cell.sum / cell.points;
  const Eigenvalues3 quadric = EigenvaluesOf(cell.quadric);
  const double largest = quadric.values(2);
  if (!(largest > 0)) return middle;
  const Vector3d residual = cell.quadric_by_point - cell.quadric * middle;
  Vector3d step = Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    if (quadric.values(i) > kLeastShare * largest) {
      const Vector3d axis = quadric.vectors.col(i);
      step += axis * (axis.dot(residual) / quadric.values(i));
    }
  if (step.norm() > cell_size) return middle;  // planes that meet far away
  return middle + step;
}

// A triangle by the cells of its corners, the smallest first.
using CellTriangle = std::array<std::uint64_t, 3>;
struct HashOfCells {
  std::size_t operator()(const CellTriangle& cells) const {
    std::uint64_t hash = 0;
    for (const std::uint64_t cell : cells) {
      hash = (hash ^ cell) * 0x9e3779b97f4a7c15ull;
      hash ^= hash >> 32;
    }
    return hash;
  }
};
using CellTriangles = std::unordered_set<CellTriangle, HashOfCells>;

class Grid {
 public:
  Grid(const TriangleMesh& mesh, const MeshSimplification& options) : mesh_(mesh), options_(options) {
    for (const Eigen::Vector3f& vertex : mesh.vertices)
      evened_.push_back(Evened(vertex.cast<double>() - options.center_in_world, options.even_within));
  }

  // `size` is that of a cell, in the mapped space.
  std::vector<std::uint64_t> CellsOf(double size) const {
    constexpr std::int64_t kHalf = 1 << 20;
    std::vector<std::uint64_t> cells;
    cells.reserve(evened_.size());
    for (const Vector3d& place : evened_) {
      std::uint64_t key = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const auto number =
            static_cast<std::int64_t>(std::clamp(std::floor(place(axis) / size), 1.0 - kHalf, kHalf - 1.0));
        key = key << 21 | static_cast<std::uint64_t>(number + kHalf);
      }
      cells.push_back(key);
    }
    return cells;
  }

  TriangleMesh With(double size) const {
    const std::vector<std::uint64_t> cell_of = CellsOf(size);
    std::unordered_map<std::uint64_t, GridCell> cells;
    for (std::size_t i = 0; i < cell_of.size(); ++i) {
      GridCell& cell = cells[cell_of[i]];
      cell.sum += mesh_.vertices[i].cast<double>();
      ++cell.points;
    }
    CellTriangles kept;
    std::vector<CellTriangle> in_order;
    for (const auto& triangle : mesh_.triangles) {
      std::array<Vector3d, 3> corner;
      CellTriangle at{};
      for (std::size_t k = 0; k < 3; ++k) {
        corner[k] = mesh_.vertices[triangle[k]].cast<double>();
        at[k] = cell_of[triangle[k]];
      }
      const Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);  // length: twice the area
      const double length = normal.norm();
      if (length > 0) {
        const Matrix3d quadric = normal * normal.transpose() / length;
        for (const std::uint64_t key : at) {
          GridCell& cell = cells[key];
          cell.quadric += quadric;
          cell.quadric_by_point += quadric * corner[0];
        }
      }
      if (at[0] == at[1] || at[1] == at[2] || at[2] == at[0]) continue;
      std::rotate(at.begin(), std::ranges::min_element(at), at.end());
      if (kept.insert(at).second) in_order.push_back(at);
    }
    TriangleMesh result;
    std::unordered_map<std::uint64_t, std::uint32_t> vertex_of;
    const auto vertex = [&](std::uint64_t key) {
      const auto [found, is_new] = vertex_of.emplace(key, static_cast<std::uint32_t>(result.vertices.size()));
      if (is_new) {
        const GridCell& cell = cells[key];
        const double distance =
            (cell.sum / cell.points - options_.center_in_world).norm() / options_.even_within;
        const double in_world = size * options_.even_within * std::max(1.0, distance);
        result.vertices.push_back(PlaceOf(cell, in_world).cast<float>());
      }
      return found->second;
    };
    for (const auto& at : in_order) result.triangles.push_back({vertex(at[0]), vertex(at[1]), vertex(at[2])});
    return result;
  }

  // Counts no further than is needed to tell.
  bool HasMoreThan(std::size_t most, double size) const {
    const std::vector<std::uint64_t> cell_of = CellsOf(size);
    CellTriangles kept;
    kept.reserve(most + 1);
    for (const auto& triangle : mesh_.triangles) {
      CellTriangle at{cell_of[triangle[0]], cell_of[triangle[1]], cell_of[triangle[2]]};
      if (at[0] == at[1] || at[1] == at[2] || at[2] == at[0]) continue;
      std::rotate(at.begin(), std::ranges::min_element(at), at.end());
      if (kept.insert(at).second && kept.size() > most) return true;
    }
    return false;
  }

 private:
  const TriangleMesh& mesh_;
  const MeshSimplification& options_;
  std::vector<Vector3d> evened_;
};

}  // namespace

TriangleMesh Simplified(const TriangleMesh& mesh, const MeshSimplification& options) {
  if (mesh.triangles.size() <= options.most_triangles) return mesh;
  const Grid grid(mesh, options);
  double fine = 1e-5, coarse = 4;  // cells that join nothing, and everything
  constexpr double kNear = 1.02;   // ratio of two sizes that count as equal
  while (coarse > kNear * fine) {
    const double size = std::sqrt(fine * coarse);
    (grid.HasMoreThan(options.most_triangles, size) ? fine : coarse) = size;
  }
  return grid.With(coarse);
}

TriangleMesh Simplified(const TriangleMesh& mesh, std::size_t most_triangles) {
  if (mesh.vertices.empty()) return mesh;
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
  return Simplified(mesh, {.center_in_world = box.center().cast<double>(),
                           .even_within = std::max(1e-30, 0.5 * static_cast<double>(box.diagonal().norm())),
                           .most_triangles = most_triangles});
}

TriangleMesh Simplified(const TriangleMesh& mesh, const std::optional<Subject>& subject,
                        std::size_t most_triangles) {
  constexpr double kEvenRadii = 2;  // Guessed.
  if (!subject || !(subject->radius > 0)) return Simplified(mesh, most_triangles);
  return Simplified(mesh, {.center_in_world = subject->center_in_world,
                           .even_within = kEvenRadii * subject->radius,
                           .most_triangles = most_triangles});
}

namespace {

std::uint64_t EdgeKey(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

// Returns indices of the new vertices in the middle of the edges that are too long.
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

// Splits one triangle by the edges that have a middle vertex.
void AppendParts(const std::array<std::uint32_t, 3>& triangle,
                 const std::unordered_map<std::uint64_t, std::uint32_t>& middles,
                 std::vector<std::array<std::uint32_t, 3>>& parts) {
  constexpr std::uint32_t kWhole = static_cast<std::uint32_t>(-1);
  std::array<std::uint32_t, 3> corner = triangle, middle{};  // for the edge that begins there
  const auto find = [&] {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto found = middles.find(EdgeKey(corner[c], corner[(c + 1) % 3]));
      middle[c] = found == middles.end() ? kWhole : found->second;
    }
  };
  find();
  const auto split = std::ranges::count_if(middle, [](std::uint32_t at) { return at != kWhole; });
  // Rotates so that the only split edge, or the only unsplit one, comes first.
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
