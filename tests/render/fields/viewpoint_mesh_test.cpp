#include "render/fields/viewpoint_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "render/fields/loop_subdivision.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf {
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
TEST(ViewpointMesh, InThePlaneOfAzimuthAndElevationThereIsASeam) {
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

TEST(ViewpointMesh, NearDuplicatesBecomeAlternatesForTheirDistance) {
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

TEST(ViewpointMesh, CamerasThatAllStoodStillAreAViewpointEach) {
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
  EXPECT_LE(rough.smoothing_rounds, kMaxSmoothingRounds);
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

TEST(ViewpointMesh, OutwardWaysLeaveTheMesh) {
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

TEST(SplitPinches, TwoTrianglesByAPointBecomeTwoPieces) {
  std::vector<Triangle> triangles{{0, 1, 2}, {2, 3, 4}};
  const auto repeated = SplitPinches(5, triangles);
  EXPECT_THAT(repeated, testing::ElementsAre(2));
  std::set<int> first(triangles[0].begin(), triangles[0].end());
  for (const int corner : triangles[1]) EXPECT_EQ(first.count(corner), 0u);
}

// ---- Weights ----

SubdividedMesh SubdivisionOf(const ViewpointMesh& mesh, int level) {
  std::vector<Vector3d> positions, outward;
  for (const auto& vertex : mesh.vertices) {
    positions.push_back(vertex.position_in_world);
    outward.push_back(vertex.outward_in_world);
  }
  return SubdivideWeights(positions, outward, mesh.triangles, level);
}

TEST(LoopSubdivision, WeightsArePositiveSumToOneAndReachTheTwoRing) {
  for (const double half_angle : {0.5, M_PI})
    for (const int level : {0, 1, 2, 3, kLimitLevel}) {
      const ViewpointMesh mesh = MakeViewpointMesh(test::CapViewpoints(70, half_angle, 2.0, 0.05), kSubject);
      const SubdividedMesh fine = SubdivisionOf(mesh, level);
      EXPECT_EQ(fine.triangles.size(), mesh.triangles.size() << (2 * std::min(level, kFinestLevel)));
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

TEST(LoopSubdivision, RegularMeshReproducesLinearFunctions) {
  // A sheared lattice: every inner vertex has six neighbours placed evenly about it.
  constexpr int kSide = 9;
  std::vector<Vector3d> positions;
  std::vector<Triangle> triangles;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) positions.emplace_back(x + 0.5 * y, std::sqrt(0.75) * y, 0);
  for (int y = 0; y + 1 < kSide; ++y)
    for (int x = 0; x + 1 < kSide; ++x) {
      const int a = y * kSide + x;
      triangles.push_back({a, a + 1, a + kSide});
      triangles.push_back({a + 1, a + kSide + 1, a + kSide});
    }
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

// The weights of the original vertices at each vertex, `levels` of subdivision beyond the third.
SubdividedMesh SubdividedFurther(const SubdividedMesh& third, int levels) {
  SubdividedMesh fine =
      SubdivideWeights(third.positions, third.outward, third.triangles, levels, Diagonals::kGiven);
  for (SparseWeights& weights : fine.weights) {
    std::map<int, double> sum;
    for (const auto& [between, share] : weights)
      for (const auto& [of, weight] : third.weights[At(between)]) sum[of] += share * weight;
    weights.assign(sum.begin(), sum.end());
  }
  return fine;
}

double Difference(const SparseWeights& a, const SparseWeights& b) {
  std::map<int, double> difference;
  for (const auto& [of, weight] : a) difference[of] += weight;
  for (const auto& [of, weight] : b) difference[of] -= weight;
  double most = 0;
  for (const auto& [of, weight] : difference) most = std::max(most, std::abs(weight));
  return most;
}

// Valences 3 to 12, a boundary with corners.
TEST(LoopSubdivision, TheLimitIsWhereSubdivisionGoes) {
  for (const int valence : {3, 4, 5, 6, 7, 12}) {
    std::vector<Vector3d> positions{{0, 0, 0}};
    std::vector<Triangle> triangles;
    for (int ring = 1; ring <= 2; ++ring)
      for (int k = 0; k < valence; ++k)
        positions.emplace_back(ring * std::cos(2 * M_PI * k / valence),
                               ring * std::sin(2 * M_PI * k / valence), 0);
    for (int k = 0; k < valence; ++k) {
      const int next = (k + 1) % valence;
      triangles.push_back({0, 1 + k, 1 + next});
      triangles.push_back({1 + k, 1 + valence + k, 1 + valence + next});
      triangles.push_back({1 + k, 1 + valence + next, 1 + next});
    }
    const std::vector<Vector3d> outward(positions.size(), Vector3d::Zero());
    const SubdividedMesh limit = SubdivideWeights(positions, outward, triangles, kLimitLevel);
    const SubdividedMesh third = SubdivideWeights(positions, outward, triangles, 3);
    const SubdividedMesh sixth = SubdividedFurther(third, 3);
    for (std::size_t v = 0; v < third.positions.size(); ++v)
      EXPECT_LT(Difference(limit.weights[v], sixth.weights[v]), 3e-4) << valence;  // a quarter a level
    EXPECT_GT(Difference(limit.weights[0], third.weights[0]), 1e-4) << valence;
    // Between the vertices of the third level, the limit is taken as linear.
    const auto topology = MakeTopology(static_cast<int>(third.positions.size()), third.triangles);
    double most = 0;
    for (std::size_t e = 0; e < topology.edges.size(); ++e) {
      const MeshEdge& edge = topology.edges[e];
      const Vector3d middle = 0.5 * (third.positions[At(edge.from)] + third.positions[At(edge.to)]);
      SparseWeights mean;
      for (const auto& [of, weight] : limit.weights[At(edge.from)]) mean.emplace_back(of, 0.5 * weight);
      for (const auto& [of, weight] : limit.weights[At(edge.to)]) mean.emplace_back(of, 0.5 * weight);
      // New vertices of a level come behind the old ones, in the order of the edges.
      const std::size_t twin = third.positions.size() + e;
      ASSERT_LT((sixth.positions[twin] - middle).norm(), 1e-12);
      most = std::max(most, Difference(mean, sixth.weights[twin]));
    }
    EXPECT_LT(most, 1.0 / 60) << valence;
  }
}

TEST(LoopSubdivision, LimitsByHand) {
  // A regular vertex keeps one half, its neighbours have a twelfth each; on a boundary it keeps all.
  constexpr int kSide = 7;
  std::vector<Vector3d> positions;
  std::vector<Triangle> triangles;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) positions.emplace_back(x + 0.5 * y, std::sqrt(0.75) * y, 0);
  for (int y = 0; y + 1 < kSide; ++y)
    for (int x = 0; x + 1 < kSide; ++x) {
      const int a = y * kSide + x;
      triangles.push_back({a, a + 1, a + kSide});
      triangles.push_back({a + 1, a + kSide + 1, a + kSide});
    }
  const SubdividedMesh limit = SubdivideWeights(
      positions, std::vector<Vector3d>(positions.size(), Vector3d::Zero()), triangles, kLimitLevel);
  const int middle = kSide / 2 * kSide + kSide / 2;
  ASSERT_EQ(limit.weights[At(middle)].size(), 7u);
  for (const auto& [of, weight] : limit.weights[At(middle)])
    EXPECT_NEAR(weight, of == middle ? 0.5 : 1.0 / 12, 1e-12);
  EXPECT_EQ(limit.weights[3], SparseWeights({{3, 1.0}}));
}

// On a square grid the diagonals are chance: the middle of a square is a quarter of each corner whichever
// was taken, and nothing jumps as a viewpoint moves over the circle of the other three.
TEST(LoopSubdivision, DoesNotPreferTheDiagonalThatDelaunayHappenedToTake) {
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
  EXPECT_LT(Difference(one, middle(corners[2], true, largest)), 1e-12);
  // Inside the circle Delaunay joins 0 and 2, outside it joins 1 and 3.
  EXPECT_LT(Difference(middle({0.99, 0.99, 0}, false, largest), middle({1.01, 1.01, 0}, true, largest)),
            0.01);
  // Far from the circle the edge is no chance.
  middle({0.6, 0.6, 0}, false, largest);
  EXPECT_GT(largest, 0.3);
}

TEST(LoopSubdivision, RulesByHand) {
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

}  // namespace
}  // namespace ulf
