// The geometry of a mesh proxy: triangles in the world frame, counter-clockwise as seen from outside.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

namespace ulf::render {

struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;                // world units
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices of vertices
};

// Returns unit normals at the vertices, means of the triangles' by area; zero for a vertex without triangles.
inline std::vector<Eigen::Vector3f> VertexNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> sums(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (const auto& corners : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[corners[0]].cast<double>();
    const Eigen::Vector3d normal =
        (mesh.vertices[corners[1]].cast<double>() - a).cross(mesh.vertices[corners[2]].cast<double>() - a);
    for (const std::uint32_t corner : corners) sums[corner] += normal;
  }
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(sums.size());
  for (const Eigen::Vector3d& sum : sums)
    normals.push_back(sum.normalized().cast<float>());  // zero stays zero
  return normals;
}

}  // namespace ulf::render
