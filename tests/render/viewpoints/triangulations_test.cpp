// Tests: render/viewpoints/delaunay,
// render/viewpoints/triangle_topology, render/viewpoints/viewpoint_mesh, render/viewpoints/near_directions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <set>

#include "render/viewpoints/delaunay.h"
#include "render/viewpoints/near_directions.h"
#include "render/viewpoints/triangle_topology.h"
#include "render/viewpoints/viewpoint_mesh.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::triangulations_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::ElementsAre;

std::size_t At(int index) { return static_cast<std::size_t>(index); }

// Spread, in clusters, in a row, and all the same.
TEST(NearDirections, EqualBruteForce) {
  for (const double jitter : {1.0, 0.01, 1e-8, 0.0})
    for (const int clusters : {1, 3}) {
      std::vector<Vector3d> directions;
      const std::vector<Vector3d> middles = test::CapViewpoints(clusters, 1.2, 1),
                                  off = test::CapViewpoints(80, 1.5, 1);
      for (std::size_t i = 0; i < off.size(); ++i)
        directions.push_back((middles[i % middles.size()].normalized() + jitter * off[i]).normalized());
      const NearDirections near(directions);
      for (std::size_t i = 0; i < directions.size(); i += 7) {
        std::vector<double> chords;
        for (const Vector3d& each : directions) chords.push_back((each - directions[i]).norm());
        std::vector<double> sorted = chords;
        std::ranges::sort(sorted);
        for (const std::size_t rank : {1u, 2u, 7u, 80u})
          EXPECT_DOUBLE_EQ(near.ChordOfNearest(directions[i], rank), sorted[rank - 1])
              << jitter << ", " << rank;
        EXPECT_EQ(near.ChordOfNearest(directions[i], 81), INFINITY);
        const double chord = sorted[12];
        std::set<std::size_t> expected, found;
        for (std::size_t j = 0; j < chords.size(); ++j)
          if ((directions[j] - directions[i]).squaredNorm() <= chord * chord) expected.insert(j);
        near.Within(directions[i], chord, [&](std::size_t j) { EXPECT_TRUE(found.insert(j).second); });
        EXPECT_EQ(found, expected) << jitter << ", " << clusters;
      }
    }
}

TEST(PlanarDelaunay, ASquareWithAMiddleIsFourTriangles) {
  const std::vector<Vector2d> points{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.4}};
  const auto triangles = PlanarDelaunay(points);
  ASSERT_EQ(triangles.size(), 4u);
  double area = 0;
  for (const Triangle& t : triangles) {
    EXPECT_EQ(std::count(t.begin(), t.end(), 4), 1);
    const Vector2d a = points[At(t[1])] - points[At(t[0])], b = points[At(t[2])] - points[At(t[0])];
    EXPECT_GT(a.x() * b.y() - a.y() * b.x(), 0) << "counter-clockwise";
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  EXPECT_NEAR(area, 1, 1e-12);
}

TEST(SphericalDelaunay, OctahedronIsClosedAndCapIsOpen) {
  std::vector<Vector3d> directions{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  const auto closed = SphericalDelaunay(directions);
  EXPECT_EQ(closed.size(), 8u);
  for (const Triangle& t : closed)
    EXPECT_GT(directions[At(t[0])].dot(directions[At(t[1])].cross(directions[At(t[2])])), 0);
  std::vector<Vector3d> cap;
  for (const Vector3d& viewpoint : test::CapViewpoints(40, 0.5, 1)) cap.push_back(viewpoint.normalized());
  const auto open = SphericalDelaunay(cap);
  const auto topology = MakeTopology(40, open);
  EXPECT_TRUE(std::any_of(topology.edges.begin(), topology.edges.end(),
                          [](const MeshEdge& edge) { return edge.OnBoundary(); }));
  EXPECT_TRUE(SphericalDelaunay({directions[0], directions[2], directions[4]}).empty()) << "too few";
  EXPECT_TRUE(SphericalDelaunay({directions.begin(), directions.begin() + 4}).empty()) << "a ring";
}

TEST(TriangleTopology, KnowsEdgesNeighboursAndBoundary) {
  // A fan of three triangles around vertex 0.
  const auto topology = MakeTopology(5, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
  EXPECT_EQ(topology.edges.size(), 7u);
  EXPECT_THAT(topology.neighbours[0], ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(topology.neighbours[2], ElementsAre(0, 1, 3));
  EXPECT_THAT(topology.boundary_neighbours[0], ElementsAre(4, 1));
  for (const MeshEdge& edge : topology.edges) {
    const bool inner =
        edge.from == 0 ? edge.to == 2 || edge.to == 3 : edge.to == 0 && (edge.from == 2 || edge.from == 3);
    EXPECT_EQ(edge.OnBoundary(), !inner) << edge.from << " " << edge.to;
  }
  const auto closed = MakeTopology(4, {{0, 1, 3}, {0, 2, 1}, {0, 3, 2}, {1, 2, 3}});
  for (int vertex = 0; vertex < 4; ++vertex) EXPECT_FALSE(closed.OnBoundary(vertex));
}

TEST(SplitPinches, TwoTrianglesByAPointBecomeTwoPieces) {
  std::vector<Triangle> triangles{{0, 1, 2}, {2, 3, 4}};
  const auto repeated = SplitPinches(5, triangles);
  EXPECT_THAT(repeated, ElementsAre(2));
  std::set<int> first(triangles[0].begin(), triangles[0].end());
  for (const int corner : triangles[1]) EXPECT_EQ(first.count(corner), 0u);
}

TEST(SubjectCenter, IsToldUpToRounding) {
  const Subject subject{{1, 2, 3}, 500};
  EXPECT_TRUE(IsAtCenter(subject, {1, 2, 3}));
  EXPECT_TRUE(IsAtCenter(subject, {1 + 1e-7, 2, 3})) << "rounding of a large subject";
  EXPECT_FALSE(IsAtCenter(subject, {1 + 1e-5, 2, 3}));
  EXPECT_TRUE(IsAtCenter(subject, {NAN, 2, 3}));
}

}  // namespace
}  // namespace ulf::triangulations_test
