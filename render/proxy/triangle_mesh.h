// Triangles in the world frame: the geometry of a mesh proxy. A triangle's corners run counter-clockwise as
// seen from outside.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace ulf::render {

struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Unit normals at the vertices, each the mean of its triangles' normals by area; zero where there is none.
std::vector<Eigen::Vector3f> VertexNormals(const TriangleMesh& mesh);

}  // namespace ulf::render
