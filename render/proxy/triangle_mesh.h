// Triangles in the world frame: the geometry of a mesh proxy. Corners are counter-clockwise as seen from
// outside.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace ulf::render {

struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;                // world units
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices of vertices
};

// Unit normals at the vertices: the mean of the triangles' normals by area; zero for a vertex without
// triangles.
std::vector<Eigen::Vector3f> VertexNormals(const TriangleMesh& mesh);

}  // namespace ulf::render
