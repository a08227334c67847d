// Tests: render/proxy/mesh_resolution.
//
// Coarser and finer meshes are the same surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>

#include "render/proxy/mesh_resolution.h"
#include "tests/measure/cpu_time.h"
#include "tests/support/floors.h"

namespace ulf::mesh_resolution_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

TriangleMesh Box(int steps) {
  TriangleMesh box;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f})
      for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
          const auto first = static_cast<std::uint32_t>(box.vertices.size());
          for (const auto& [di, dj] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
            Vector3f corner;
            corner[axis] = side;
            corner[(axis + 1) % 3] = 2.0f * static_cast<float>(i + di) / static_cast<float>(steps) - 1;
            corner[(axis + 2) % 3] = 2.0f * static_cast<float>(j + dj) / static_cast<float>(steps) - 1;
            box.vertices.push_back(corner);
          }
          box.triangles.push_back({first, first + 1, first + 2});
          box.triangles.push_back({first, first + 2, first + 3});
        }
  return box;
}

TEST(MeshResolution, ACoarserBoxKeepsFacesAndCorners) {
  const TriangleMesh fine = Box(40);
  const TriangleMesh coarse = Simplified(fine, 1500);
  EXPECT_LE(coarse.triangles.size(), 1500u);
  EXPECT_GT(coarse.triangles.size(), 500u);
  float farthest = 0;
  for (const Vector3f& vertex : coarse.vertices) {
    EXPECT_NEAR(vertex.cwiseAbs().maxCoeff(), 1, 1e-3);  // on a face
    farthest = std::max(farthest, vertex.cwiseAbs().minCoeff());
  }
  EXPECT_NEAR(farthest, 1, 1e-3);  // a corner
  EXPECT_EQ(Simplified(fine, fine.triangles.size()).vertices.size(), fine.vertices.size());
}

TEST(MeshResolution, CoarsensAMillionInTheTimeOfReading) {
  const TriangleMesh fine = Box(300);
  ASSERT_GT(fine.triangles.size(), 1000000u);
  const double start_s = CpuSeconds();
  VertexNormals(fine);
  const double once_s = CpuSeconds() - start_s;
  const TriangleMesh coarse = Simplified(fine, 20000);
  EXPECT_LT(CpuSeconds() - start_s, 30 * once_s);
  EXPECT_LE(coarse.triangles.size(), 20000u);
}

TEST(MeshSplit, AFinerMeshIsTheSameSurfaceWithoutCracks) {
  const TriangleMesh one{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {4, 4, 0}}, {{0, 1, 2}, {1, 3, 2}}};
  const std::vector<Vector3d> centers{{0.5, 0.5, 1}};
  const TriangleMesh fine = Split(one, centers, 0.2, 100000);
  double area = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& triangle : fine.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const Vector3f &a = fine.vertices[triangle[c]], &b = fine.vertices[triangle[(c + 1) % 3]];
      if (c == 0) {
        const Vector3f normal = (b - a).cross(fine.vertices[triangle[2]] - a);
        EXPECT_GT(normal.z(), 0);  // turned as before
        area += 0.5 * static_cast<double>(normal.norm());
      }
      EXPECT_LE(static_cast<double>((a - b).norm()),
                0.2 * (centers[0] - 0.5 * (a + b).cast<double>()).norm() + 1e-6);
      ++edges[std::minmax(triangle[c], triangle[(c + 1) % 3])];
    }
  EXPECT_NEAR(area, 16, 1e-3);
  for (const auto& [edge, count] : edges) {
    const Vector3f middle = 0.5f * (fine.vertices[edge.first] + fine.vertices[edge.second]);
    const bool is_rim = std::min({middle.x(), middle.y(), 4 - middle.x(), 4 - middle.y()}) < 1e-6f;
    EXPECT_EQ(count, is_rim ? 1 : 2);
  }
  EXPECT_LT(Split(one, centers, 1e-4, 1000).triangles.size(), 4001u);  // it ends
}

}  // namespace
}  // namespace ulf::mesh_resolution_test
