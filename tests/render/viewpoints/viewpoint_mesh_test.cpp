// Tests: render/viewpoints/viewpoint_mesh.
#include "render/viewpoints/viewpoint_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>
#include <set>

#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::viewpoint_mesh_test {
namespace {

using Eigen::Vector3d;

const Subject kSubject{Vector3d::Zero(), 0.2};

std::size_t At(int index) { return static_cast<std::size_t>(index); }

// Manifold, outward, every vertex used.
void ExpectSound(const ViewpointMesh& mesh, const std::string& name) {
  ASSERT_EQ(mesh.span, Span::kSurface) << name << ": " << mesh.Description();
  std::set<std::pair<int, int>> directed;
  std::set<int> used;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_TRUE(directed.insert({t[k], t[(k + 1) % 3]}).second)
          << name << ": an edge runs twice the same way";
      used.insert(t[k]);
    }
    const auto arm = [&](int k) -> Vector3d {
      return mesh.vertices[At(t[At(k)])].position_in_world - mesh.center_in_world;
    };
    EXPECT_GT(arm(0).dot(arm(1).cross(arm(2))), 0) << name;
  }
  EXPECT_EQ(used.size(), mesh.vertices.size()) << name << ": a viewpoint is in no triangle";
  EXPECT_EQ(mesh.confidence.size(), mesh.triangles.size());
}

int EulerNumber(const ViewpointMesh& mesh) {
  const auto topology = MakeTopology(static_cast<int>(mesh.vertices.size()), mesh.triangles);
  return static_cast<int>(mesh.vertices.size()) - static_cast<int>(topology.edges.size()) +
         static_cast<int>(mesh.triangles.size());
}

TEST(ViewpointMesh, CapsAreDiscsAndSpheresAreClosed) {
  for (const int count : {20, 60, 300})
    for (const double half_angle_deg : {10.0, 40.0, 80.0, 180.0})
      for (const double jitter : {0.0, 0.05, 0.2}) {
        const auto viewpoints = test::CapViewpoints(count, half_angle_deg * M_PI / 180, 2.0, jitter);
        const ViewpointMesh mesh = MakeViewpointMesh(viewpoints, {Vector3d::Zero(), 0.05});
        const std::string name = testing::PrintToString(std::make_tuple(count, half_angle_deg, jitter));
        ExpectSound(mesh, name);
        const bool closed = half_angle_deg == 180;
        EXPECT_EQ(EulerNumber(mesh), closed ? 2 : 1) << name;
        EXPECT_EQ(mesh.boundary_vertices == 0, closed) << name;
        EXPECT_EQ(mesh.vertices.size(), viewpoints.size()) << name;
      }
}

// As the thesis did it: the same cap, and a seam where viewpoints stand all around.
TEST(ViewpointMesh, AzimuthElevationPlaneHasASeam) {
  const ViewpointMeshOptions in_plane{.in_plane = true, .up_in_world = Vector3d::UnitY()};
  const auto cap = test::CapViewpoints(120, 0.6, 2.0, 0.05);
  const ViewpointMesh plane = MakeViewpointMesh(cap, kSubject, in_plane),
                      sphere = MakeViewpointMesh(cap, kSubject);
  ExpectSound(plane, "cap");
  EXPECT_NEAR(static_cast<double>(plane.triangles.size()), static_cast<double>(sphere.triangles.size()),
              0.1 * static_cast<double>(sphere.triangles.size()));
  const auto around = test::CapViewpoints(200, M_PI, 2.0);
  EXPECT_EQ(MakeViewpointMesh(around, kSubject).boundary_vertices, 0);
  EXPECT_GT(MakeViewpointMesh(around, kSubject, in_plane).boundary_vertices, 10);
}

TEST(ViewpointMesh, SubjectNeedNotBeTheOrigin) {
  const Vector3d center(5, -3, 11);
  auto viewpoints = test::CapViewpoints(80, 0.6, 2.0, 0.05);
  const ViewpointMesh at_origin = MakeViewpointMesh(viewpoints, kSubject);
  for (Vector3d& c : viewpoints) c += center;
  const ViewpointMesh moved = MakeViewpointMesh(viewpoints, {center, kSubject.radius});
  ExpectSound(moved, "moved");
  EXPECT_EQ(moved.triangles.size(), at_origin.triangles.size());
}

TEST(ViewpointMesh, PlanarGridHasNoSliversOnItsRim) {
  const ViewpointMesh mesh = MakeViewpointMesh(test::GridViewpoints(14, 14, 0.06, 8.12), kSubject);
  ExpectSound(mesh, "grid");
  EXPECT_EQ(mesh.triangles.size(), 2u * 13 * 13);
  EXPECT_EQ(mesh.boundary_vertices, 4 * 13);
  EXPECT_EQ(mesh.smoothing_rounds, 0);
}

// An L of viewpoints: the triangulation's hull spans the missing quarter, trimming takes that away.
TEST(ViewpointMesh, TrimsTheHollowOfAnL) {
  std::vector<Vector3d> viewpoints;
  for (const Vector3d& c : test::GridViewpoints(15, 15, 0.05, 3.0))
    if (c.x() < -0.05 || c.y() < -0.05) viewpoints.push_back(c);
  const ViewpointMesh mesh = MakeViewpointMesh(viewpoints, kSubject);
  ExpectSound(mesh, "L");
  EXPECT_EQ(EulerNumber(mesh), 1);
  EXPECT_FALSE(InsideHull(mesh, Vector3d(0.25, 0.25, 3.0)));
  EXPECT_TRUE(InsideHull(mesh, Vector3d(-0.2, 0.2, 3.0)));
  EXPECT_TRUE(InsideHull(mesh, Vector3d(0.2, -0.2, 3.0)));
}

TEST(ViewpointMesh, HolesInsideStayWithLessConfidence) {
  std::vector<Vector3d> viewpoints;
  for (const Vector3d& c : test::GridViewpoints(21, 21, 0.05, 3.0))
    if (c.head<2>().norm() > 0.28) viewpoints.push_back(c);
  const ViewpointMesh mesh = MakeViewpointMesh(viewpoints, kSubject);
  ExpectSound(mesh, "hole");
  EXPECT_EQ(EulerNumber(mesh), 1);
  EXPECT_TRUE(InsideHull(mesh, Vector3d(0, 0, 3)));
  EXPECT_LT(*std::min_element(mesh.confidence.begin(), mesh.confidence.end()), 0.9);
  EXPECT_EQ(*std::max_element(mesh.confidence.begin(), mesh.confidence.end()), 1.0);
}

TEST(ViewpointMesh, NearDuplicatesBecomeAlternates) {
  auto viewpoints = test::CapViewpoints(60, 0.6, 2.0);
  const std::size_t base = viewpoints.size();
  for (std::size_t i = 0; i < base; i += 2) viewpoints.push_back(1.3 * viewpoints[i] + Vector3d(1e-4, 0, 0));
  const ViewpointMesh mesh = MakeViewpointMesh(viewpoints, kSubject);
  ExpectSound(mesh, "duplicates");
  EXPECT_EQ(mesh.vertices.size(), base);
  for (std::size_t v = 0; v < base; ++v) {
    const bool doubled = mesh.vertices[v].views.size() == 2;
    EXPECT_EQ(doubled, v % 2 == 0) << v;
    if (!doubled) continue;
    EXPECT_LT(mesh.ViewAt(static_cast<int>(v), 2.0, viewpoints), static_cast<int>(base));
    EXPECT_GE(mesh.ViewAt(static_cast<int>(v), 2.6, viewpoints), static_cast<int>(base));
  }
}

TEST(ViewpointMesh, ACameraThatStoodStillIsOneViewpoint) {
  auto viewpoints = test::CapViewpoints(40, 0.6, 2.0);
  std::mt19937 random(3);
  std::normal_distribution<double> tremor(0, 1e-4);
  for (int i = 0; i < 30; ++i)
    viewpoints.push_back(viewpoints[7] + Vector3d(tremor(random), tremor(random), tremor(random)));
  const ViewpointMesh mesh = MakeViewpointMesh(viewpoints, kSubject);
  ExpectSound(mesh, "still");
  EXPECT_EQ(mesh.vertices.size(), 40u);
}

TEST(ViewpointMesh, AllStillCamerasAreAViewpointEach) {
  std::mt19937 random(4);
  std::normal_distribution<double> tremor(0, 1e-4);
  for (const int each : {3, 7, 30}) {
    std::vector<Vector3d> viewpoints;
    for (const Vector3d& place : test::CapViewpoints(40, 0.6, 2.0, 0.05))
      for (int i = 0; i < each; ++i)
        viewpoints.push_back(place + Vector3d(tremor(random), tremor(random), tremor(random)));
    const ViewpointMesh mesh = MakeViewpointMesh(viewpoints, kSubject);
    ExpectSound(mesh, std::to_string(each) + " each");
    EXPECT_EQ(mesh.vertices.size(), 40u) << each;
    for (const auto& vertex : mesh.vertices) EXPECT_EQ(vertex.views.size(), At(each));
  }
}

TEST(ViewpointMesh, SmoothsOnlyWhileItFolds) {
  const ViewpointMesh even =
      MakeViewpointMesh(test::CapViewpoints(100, 0.6, 2.0, 0.02), {Vector3d::Zero(), 0.2});
  EXPECT_EQ(even.smoothing_rounds, 0);

  auto viewpoints = test::CapViewpoints(300, 0.6, 2.0);
  for (std::size_t i = 0; i < viewpoints.size(); i += 3) viewpoints[i] *= 1.6;
  const Subject subject{Vector3d::Zero(), 0.4};
  const ViewpointMesh rough = MakeViewpointMesh(viewpoints, subject);
  ExpectSound(rough, "rough");
  EXPECT_GT(rough.smoothing_rounds, 0);
  EXPECT_LE(rough.smoothing_rounds, kMostSmoothingRounds);
  EXPECT_FALSE(rough.folds_remain);
  for (std::size_t v = 0; v < rough.vertices.size(); ++v) {
    const Vector3d& before = viewpoints[At(rough.vertices[v].views.front())];
    EXPECT_LT(before.normalized().cross(rough.vertices[v].position_in_world.normalized()).norm(), 1e-9)
        << "smoothing is radial";
  }
}

TEST(ViewpointMesh, SetsWithoutASurfaceSaySo) {
  struct Case {
    std::string name;
    std::vector<Vector3d> viewpoints;
    Span span;
  };
  std::vector<Vector3d> row, ray;
  for (int i = 0; i < 12; ++i) {
    row.emplace_back(0.1 * i - 0.5, 0.001 * (i % 2), 2);
    ray.push_back((1 + 0.1 * i) * Vector3d(0.1, 0.2, 2));
  }
  const std::vector<Case> cases{
      {"none", {}, Span::kPlace},
      {"one", {{0, 0, 2}}, Span::kPlace},
      {"at the centre", {{0, 0, 0}}, Span::kPlace},
      {"all in one place", std::vector<Vector3d>(9, Vector3d(0.3, 0, 2)), Span::kPlace},
      {"two", {{0, 0, 2}, {0.2, 0, 2}}, Span::kLine},
      {"three", {{0, 0, 2}, {0.2, 0, 2}, {0, 0.2, 2}}, Span::kLine},
      {"four", {{0, 0, 2}, {0.2, 0, 2}, {0, 0.2, 2}, {0.2, 0.2, 2}}, Span::kLine},
      {"row", row, Span::kLine},
      {"along one ray", ray, Span::kLine},
      {"ring", test::RingViewpoints(47, 0, 2), Span::kLine},
      {"ring with noise", test::RingViewpoints(47, 0, 2, 0.01), Span::kLine},
      {"raised ring", test::RingViewpoints(47, 0.4, 2), Span::kLine},
      {"raised ring with noise", test::RingViewpoints(47, 0.4, 2, 0.01), Span::kLine},
  };
  for (const Case& c : cases) {
    const ViewpointMesh mesh = MakeViewpointMesh(c.viewpoints, kSubject);
    EXPECT_EQ(mesh.span, c.span) << c.name << ": " << mesh.Description();
    EXPECT_FALSE(mesh.Description().empty());
  }
}

TEST(ViewpointMesh, OutwardDirectionsLeaveTheMesh) {
  const auto viewpoints = test::CapViewpoints(120, 0.7, 2.0, 0.03);
  const ViewpointMesh mesh = MakeViewpointMesh(viewpoints, {Vector3d::Zero(), 0.05});
  int boundary = 0;
  for (const auto& vertex : mesh.vertices) {
    if (vertex.outward_in_world.isZero(0)) continue;
    ++boundary;
    EXPECT_LT(std::abs(vertex.outward_in_world.normalized().dot(vertex.position_in_world.normalized())),
              1e-9);
    EXPECT_FALSE(InsideHull(mesh, vertex.position_in_world + 0.05 * vertex.outward_in_world));
  }
  EXPECT_EQ(boundary, mesh.boundary_vertices);
  EXPECT_GT(boundary, 10);
}

}  // namespace
}  // namespace ulf::viewpoint_mesh_test
