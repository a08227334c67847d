// Tests: render/fields/loop_subdivision.
#include "render/fields/loop_subdivision.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "render/viewpoints/viewpoint_mesh.h"
#include "tests/render/fields/weights_difference.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::loop_subdivision_test {
namespace {

using Eigen::Vector3d;
using test::LargestDifference;

const Subject kSubject{Vector3d::Zero(), 0.2};

std::size_t At(int index) { return static_cast<std::size_t>(index); }

SubdividedMesh SubdivisionOf(const ViewpointMesh& mesh, int level) {
  std::vector<Vector3d> positions, outward;
  for (const auto& vertex : mesh.vertices) {
    positions.push_back(vertex.position_in_world);
    outward.push_back(vertex.outward_in_world);
  }
  return SubdivideWeights(positions, outward, mesh.triangles, level);
}

TEST(LoopSubdivision, WeightsArePositiveAndSumToOne) {
  for (const double half_angle : {0.5, M_PI})
    for (const int level : {0, 1, 2, 3}) {
      const ViewpointMesh mesh = MakeViewpointMesh(test::CapViewpoints(70, half_angle, 2.0, 0.05), kSubject);
      const SubdividedMesh fine = SubdivisionOf(mesh, level);
      EXPECT_EQ(fine.triangles.size(), mesh.triangles.size() << (2 * level));
      const auto topology = MakeTopology(static_cast<int>(mesh.vertices.size()), mesh.triangles);
      for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
        // Whatever weighs in a triangle stands within two edges of the original triangle's corners.
        std::set<int> ring(mesh.triangles[At(fine.parent[t])].begin(),
                           mesh.triangles[At(fine.parent[t])].end());
        const std::set<int> corners = ring;
        for (const int corner : corners)
          ring.insert(topology.neighbours[At(corner)].begin(), topology.neighbours[At(corner)].end());
        for (const int vertex : fine.triangles[t]) {
          double sum = 0;
          for (const auto& [of, weight] : fine.weights[At(vertex)]) {
            EXPECT_GE(weight, 0);
            EXPECT_TRUE(ring.count(of)) << "level " << level;
            sum += weight;
          }
          ASSERT_NEAR(sum, 1, 1e-12);
        }
      }
    }
}

// Every inner vertex has six neighbours placed evenly about it.
std::pair<std::vector<Vector3d>, std::vector<Triangle>> ShearedLattice(int side) {
  std::vector<Vector3d> positions;
  std::vector<Triangle> triangles;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) positions.emplace_back(x + 0.5 * y, std::sqrt(0.75) * y, 0);
  for (int y = 0; y + 1 < side; ++y)
    for (int x = 0; x + 1 < side; ++x) {
      const int a = y * side + x;
      triangles.push_back({a, a + 1, a + side});
      triangles.push_back({a + 1, a + side + 1, a + side});
    }
  return {positions, triangles};
}

TEST(LoopSubdivision, ReproducesLinearFunctions) {
  constexpr int kSide = 9;
  const auto [positions, triangles] = ShearedLattice(kSide);
  const auto linear = [](const Vector3d& p) { return 0.7 * p.x() - 1.3 * p.y() + 4; };
  for (const int level : {1, 2, 3}) {
    const SubdividedMesh fine = SubdivideWeights(
        positions, std::vector<Vector3d>(positions.size(), Vector3d::Zero()), triangles, level);
    int checked = 0;
    for (std::size_t v = 0; v < fine.positions.size(); ++v) {
      bool inner = true;
      double value = 0;
      for (const auto& [of, weight] : fine.weights[v]) {
        const int x = of % kSide, y = of / kSide;
        inner = inner && x > 0 && y > 0 && x + 1 < kSide && y + 1 < kSide;
        value += weight * linear(positions[At(of)]);
      }
      if (!inner) continue;
      ++checked;
      EXPECT_NEAR(value, linear(fine.positions[v]), 1e-12) << "level " << level;
    }
    EXPECT_GT(checked, 20);
    // The weights of a regular vertex itself, and their way towards one half.
    const int middle = kSide / 2 * kSide + kSide / 2;
    double own = 0;
    for (const auto& [of, weight] : fine.weights[At(middle)])
      if (of == middle) own = weight;
    const double expected =
        0.5 + 0.125 * std::pow(0.25, level - 1);  // 5/8, then a quarter of the excess each level
    EXPECT_NEAR(own, expected, 1e-12) << "level " << level;
  }
}

// On a square grid the diagonals are chance: the middle of a square is a quarter of each corner whichever
// was taken, and nothing jumps as a viewpoint moves over the circle of the other three.
TEST(LoopSubdivision, IgnoresTheChosenDiagonal) {
  const std::vector<Vector3d> corners{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const auto middle = [&](const Vector3d& moved, bool other_diagonal, double& largest_share) {
    std::vector<Vector3d> positions = corners;
    positions[2] = moved;
    const std::vector<Triangle> triangles = other_diagonal ? std::vector<Triangle>{{0, 1, 3}, {1, 2, 3}}
                                                           : std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}};
    const SubdividedMesh fine =
        SubdivideWeights(positions, std::vector<Vector3d>(4, Vector3d::Zero()), triangles, 1);
    for (std::size_t v = 4; v < fine.positions.size(); ++v)
      if (fine.weights[v].size() == 4) {
        largest_share = 0;
        for (const auto& [of, weight] : fine.weights[v]) largest_share = std::max(largest_share, weight);
        return fine.weights[v];
      }
    return SparseWeights();
  };
  double largest = 0;
  const SparseWeights one = middle(corners[2], false, largest);
  ASSERT_EQ(one.size(), 4u);
  EXPECT_NEAR(largest, 0.25, 1e-12);
  EXPECT_LT(LargestDifference(one, middle(corners[2], true, largest)), 1e-12);
  // Inside the circle Delaunay joins 0 and 2, outside it joins 1 and 3.
  EXPECT_LT(
      LargestDifference(middle({0.99, 0.99, 0}, false, largest), middle({1.01, 1.01, 0}, true, largest)),
      0.01);
  // Far from the circle the edge is no chance.
  middle({0.6, 0.6, 0}, false, largest);
  EXPECT_GT(largest, 0.3);
}

TEST(LoopSubdivision, FollowsRulesWorkedOutByHand) {
  // A closed tetrahedron: valence three everywhere.
  const std::vector<Vector3d> corners{{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
  const std::vector<Triangle> faces{{0, 1, 3}, {0, 2, 1}, {0, 3, 2}, {1, 2, 3}};
  const SubdividedMesh fine = SubdivideWeights(corners, std::vector<Vector3d>(4, Vector3d::Zero()), faces, 1);
  for (const auto& [of, weight] : fine.weights[0]) EXPECT_NEAR(weight, of == 0 ? 7.0 / 16 : 3.0 / 16, 1e-15);
  for (const auto& [of, weight] : fine.weights[4]) EXPECT_TRUE(weight == 0.375 || weight == 0.125) << of;
  // One triangle alone: all boundary.
  const SubdividedMesh open = SubdivideWeights({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                               std::vector<Vector3d>(3, Vector3d::Zero()), {{0, 1, 2}}, 1);
  EXPECT_EQ(open.weights[1], SparseWeights({{1, 1.0}}));
  for (std::size_t v = 3; v < 6; ++v)
    for (const auto& [of, weight] : open.weights[v]) EXPECT_NEAR(weight, 0.5, 1e-15) << of;
}

TEST(LoopSubdivision, FollowsLoopsOwnRulesByHand) {
  const std::vector<Vector3d> still(3, Vector3d::Zero());
  const std::vector<Vector3d> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const SubdividedMesh open = SubdivideWeights(corners, still, {{0, 1, 2}}, 1, SubdivisionRules::kLoop);
  EXPECT_EQ(open.weights[1], SparseWeights({{0, 0.125}, {1, 0.75}, {2, 0.125}}));
  for (std::size_t v = 3; v < 6; ++v)
    for (const auto& [of, weight] : open.weights[v]) EXPECT_EQ(weight, 0.5) << of;
  const auto weight_of = [](const SparseWeights& weights, int vertex) {
    for (const auto& [of, weight] : weights)
      if (of == vertex) return weight;
    return 0.0;
  };
  // A square's diagonal is no better than any edge.
  const std::vector<Vector3d> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const SubdividedMesh split = SubdivideWeights(square, std::vector<Vector3d>(4, Vector3d::Zero()),
                                                {{0, 1, 2}, {0, 2, 3}}, 1, SubdivisionRules::kLoop);
  bool seen = false;
  for (std::size_t v = 4; v < split.weights.size(); ++v)
    if (split.weights[v].size() == 4) {
      seen = true;
      EXPECT_EQ(weight_of(split.weights[v], 0), 0.375);
      EXPECT_EQ(weight_of(split.weights[v], 1), 0.125);
    }
  EXPECT_TRUE(seen);
}

}  // namespace
}  // namespace ulf::loop_subdivision_test
