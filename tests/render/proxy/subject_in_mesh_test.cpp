// Tests: render/proxy/subject_in_mesh.
//
// How large a subject is found to be in a mesh of what views saw of it, against what the scene's maker says.
#include "render/proxy/subject_in_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/geometry/angles.h"
#include "tests/render/prediction/seen_scene.h"

namespace ulf::subject_in_mesh_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// A mesh of rings: `at` gives the point for two shares of the whole.
template <typename At>
void AddSheet(int rings, int steps, const At& at, TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int r = 0; r <= rings; ++r)
    for (int s = 0; s <= steps; ++s)
      mesh.vertices.push_back(at(static_cast<double>(r) / rings, static_cast<double>(s) / steps));
  for (int r = 0; r < rings; ++r)
    for (int s = 0; s < steps; ++s) {
      const auto corner = first + static_cast<std::uint32_t>(r * (steps + 1) + s);
      const auto below = corner + static_cast<std::uint32_t>(steps + 1);
      mesh.triangles.push_back({corner, below, corner + 1});
      mesh.triangles.push_back({corner + 1, below, below + 1});
    }
}

// The half of a ball that one side sees, over a table.
TriangleMesh BallOnTable(const Vector3d& center, double radius, double table_z) {
  TriangleMesh mesh;
  AddSheet(
      24, 24,
      [&](double a, double b) {
        const double down = M_PI * a, round = M_PI * b;
        return Vector3f((center + radius * Vector3d(std::sin(down) * std::cos(round),
                                                    std::sin(down) * std::sin(round), std::cos(down)))
                            .cast<float>());
      },
      mesh);
  AddSheet(
      30, 30,
      [&](double a, double b) {
        return Vector3f(static_cast<float>(6 * a - 3), static_cast<float>(6 * b - 3),
                        static_cast<float>(table_z));
      },
      mesh);
  return mesh;
}

TEST(SubjectInMesh, FindsTheBallOnATableForAnySphere) {
  const Vector3d center(0.1, 0, 0.5);
  const TriangleMesh mesh = BallOnTable(center, 0.3, 0.15);
  for (const double size : {0.7, 1.0, 2.0, 3.0}) {
    const auto found = SubjectInMesh(mesh, {Vector3d(0, 0, 0.45), 0.3 * size});
    ASSERT_TRUE(found) << size;
    EXPECT_NEAR(found->radius, 0.3, 0.03) << size;
    EXPECT_LT((found->center_in_world - center).norm(), 0.05) << size;
  }
}

TEST(SubjectInMesh, ExcludesWhatContinuesIntoTheScene) {
  TriangleMesh wall;
  AddSheet(
      30, 30,
      [](double a, double b) {
        return Vector3f(static_cast<float>(6 * a - 3), static_cast<float>(6 * b - 3), 0);
      },
      wall);
  EXPECT_FALSE(SubjectInMesh(wall, {Vector3d::Zero(), 0.5}));
  EXPECT_FALSE(SubjectInMesh({}, {Vector3d::Zero(), 0.5}));
  EXPECT_FALSE(SubjectInMesh(wall, {Vector3d(50, 0, 0), 0.5})) << "nothing near";
}

class SubjectInSeenMesh : public ::testing::TestWithParam<const char*> {};

TEST_P(SubjectInSeenMesh, HasItsTrueSizeForAnySphere) {
  const test::SeenScene seen(GetParam(), Radians(10));
  const Subject& truth = seen.subject();
  for (const double size : {0.6, 1.0, 1.8}) {
    const auto found = SubjectInMesh(*seen.mesh(), {truth.center_in_world, size * truth.radius});
    ASSERT_TRUE(found) << size;
    printf("%s, sphere %.1f: radius %.2f of the scene's, off by %.2f\n", GetParam(), size,
           found->radius / truth.radius,
           (found->center_in_world - truth.center_in_world).norm() / truth.radius);
    // The scene's sphere encloses the whole, views from one side see its front.
    EXPECT_GT(found->radius, 0.65 * truth.radius) << size;
    EXPECT_LT(found->radius, 1.2 * truth.radius) << size;
    EXPECT_LT((found->center_in_world - truth.center_in_world).norm(), 0.5 * truth.radius) << size;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, SubjectInSeenMesh, ::testing::Values("studio", "plant", "bust"),
                         [](const auto& scene) { return std::string(scene.param); });

}  // namespace
}  // namespace ulf::subject_in_mesh_test
