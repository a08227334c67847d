// Simplifies and refines meshes.
//
// Simplification merges vertices that lie in one cell of a grid (Rossignac and Borrel 1993), at the place
// that is nearest to the planes of their triangles (Lindstrom 2000, "Out-of-core simplification of large
// polygonal models"). The mesh need not be a manifold. Cells have one size, or grow with the distance from a
// centre, as the scene does in pictures that are taken around it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

struct MeshSimplification {
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  double even_within = 1;  // world units: nearer to the centre than this all cells have one size
  std::size_t most_triangles = 20000;
};

// Returns a mesh of at most `most_triangles`, and of not many fewer if possible; the given one if it has no
// more. Triangles that collapse or coincide are left out.
TriangleMesh Simplified(const TriangleMesh& mesh, const MeshSimplification& options);
// Does the same with cells of one size everywhere.
TriangleMesh Simplified(const TriangleMesh& mesh, std::size_t most_triangles);
// Does the same with cells of one size around the subject; everywhere without one.
TriangleMesh Simplified(const TriangleMesh& mesh, const std::optional<Subject>& subject,
                        std::size_t most_triangles);

// Meshes of other programs with more triangles are made coarser: no picture shows more, and each costs time
// in every picture.
inline constexpr std::size_t kMostTrianglesShown = 1'000'000;

// Refines a mesh: in each round, edges longer than `most_slope` times the distance from their middle to the
// nearest view are halved, until there are none, or at least `most_triangles`. Triangles that share an edge
// split it alike. `view_centers` are in the world frame.
TriangleMesh Split(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& view_centers,
                   double most_slope, std::size_t most_triangles);

}  // namespace ulf::render
