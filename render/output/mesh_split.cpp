#include "render/output/mesh_split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <unordered_map>

#include "core/geometry/small_matrices.h"

namespace ulf::render {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The squared distance to the planes of a cell's triangles, by their areas: x^T a x - 2 b x.
struct ClusteredVertex {
  Matrix3d a = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero(), sum = Vector3d::Zero();
  double count = 0;
};

class ClusterGrid {
 public:
  ClusterGrid(const TriangleMesh& mesh, double size) : mesh_(mesh), size_(size) {
    low_ = mesh.vertices.front().cast<double>();
    for (const Eigen::Vector3f& vertex : mesh.vertices) low_ = low_.cwiseMin(vertex.cast<double>());
    std::unordered_map<std::uint64_t, std::uint32_t> numbers;
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
      const Vector3d at = ((vertex.cast<double>() - low_) / size).array().floor();
      constexpr double kMost = (1 << 21) - 1;
      std::uint64_t key = 0;
      for (int axis = 0; axis < 3; ++axis)
        key = (key << 21) | static_cast<std::uint64_t>(std::min(at[axis], kMost));
      cell_.push_back(numbers.try_emplace(key, static_cast<std::uint32_t>(numbers.size())).first->second);
    }
    cells_ = numbers.size();
    std::set<std::array<std::uint32_t, 3>> known;
    for (const auto& triangle : mesh.triangles) {
      std::array<std::uint32_t, 3> merged{cell_[triangle[0]], cell_[triangle[1]], cell_[triangle[2]]};
      if (merged[0] == merged[1] || merged[1] == merged[2] || merged[2] == merged[0]) continue;
      std::rotate(merged.begin(), std::ranges::min_element(merged), merged.end());
      if (known.insert(merged).second) triangles_.push_back(merged);
    }
  }

  std::size_t Triangles() const { return triangles_.size(); }

  TriangleMesh Mesh() const {
    std::vector<ClusteredVertex> cells(cells_);
    for (std::size_t i = 0; i < cell_.size(); ++i) {
      ClusteredVertex& cell = cells[cell_[i]];
      cell.sum += mesh_.vertices[i].cast<double>();
      ++cell.count;
    }
    for (const auto& triangle : mesh_.triangles) {
      const Vector3d p = mesh_.vertices[triangle[0]].cast<double>();
      const Vector3d normal = (mesh_.vertices[triangle[1]].cast<double>() - p)
                                  .cross(mesh_.vertices[triangle[2]].cast<double>() - p);
      const double area = normal.norm();
      if (!(area > 0)) continue;
      for (const std::uint32_t corner : triangle) {
        ClusteredVertex& cell = cells[cell_[corner]];
        cell.a += normal * normal.transpose() / area;
        cell.b += normal * (normal.dot(p) / area);
      }
    }
    TriangleMesh mesh;
    for (const ClusteredVertex& cell : cells) mesh.vertices.push_back(PlaceOf(cell).cast<float>());
    mesh.triangles = triangles_;
    return mesh;
  }

 private:
  // From the mean along the directions that the planes determine, and not out of the cell's neighbourhood.
  Vector3d PlaceOf(const ClusteredVertex& cell) const {
    constexpr double kDetermined = 0.05;  // of the largest singular value. Guessed.
    const Vector3d mean = cell.sum / cell.count;
    const SingularValues3 svd = SingularValuesOf(cell.a);
    if (!(svd.values[0] > 0)) return mean;
    const Vector3d off = svd.u.transpose() * (cell.b - cell.a * mean);
    Vector3d step = Vector3d::Zero();
    for (int i = 0; i < 3; ++i)
      if (svd.values[i] > kDetermined * svd.values[0]) step += svd.v.col(i) * (off[i] / svd.values[i]);
    return step.norm() < size_ ? Vector3d(mean + step) : mean;
  }

  const TriangleMesh& mesh_;
  double size_;
  Vector3d low_;
  std::vector<std::uint32_t> cell_;  // of each vertex
  std::size_t cells_ = 0;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
};

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

TriangleMesh Clustered(const TriangleMesh& mesh, std::size_t most_triangles) {
  if (mesh.triangles.size() <= most_triangles) return mesh;
  Eigen::Vector3f low = mesh.vertices.front(), high = low;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  const double extent = std::max(1e-30, static_cast<double>((high - low).maxCoeff()));
  // By the logarithm of the cell's size.
  double too_many = std::log(extent / (1 << 20)), fits = std::log(2 * extent);
  for (int step = 0; step < 20; ++step) {
    const double middle = 0.5 * (too_many + fits);
    (ClusterGrid(mesh, std::exp(middle)).Triangles() <= most_triangles ? fits : too_many) = middle;
  }
  return ClusterGrid(mesh, std::exp(fits)).Mesh();
}

}  // namespace ulf::render
