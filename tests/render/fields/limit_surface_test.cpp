// Tests: render/fields/limit_surface, render/fields/box_spline, render/fields/limit_pieces,
// render/fields/weight_sum.
#include "render/fields/limit_surface.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/base/at.h"
#include "render/fields/limit_pieces.h"
#include "render/fields/weight_sum.h"
#include "render/viewpoints/viewpoint_mesh.h"
#include "tests/render/fields/weights_difference.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::LargestDifference;

constexpr std::array kBothRules{SubdivisionRules::kDelaunay, SubdivisionRules::kLoop};
const char* NameOf(SubdivisionRules rules) { return rules == SubdivisionRules::kLoop ? "Loop" : "Delaunay"; }

struct Mesh {
  std::vector<Vector3d> positions;
  std::vector<Triangle> triangles;

  std::vector<Vector3d> Outward() const { return std::vector<Vector3d>(positions.size(), Vector3d::Zero()); }
  LimitSurface Limit(SubdivisionRules rules) const { return LimitSurface(positions, triangles, rules); }
};

// A vertex of this valence, two rings about it, a rim with corners. `open`: of the sectors of the first ring one is
// left out, so that the vertex is on the rim.
Mesh Wheel(int valence, bool open = false) {
  Mesh mesh;
  mesh.positions.emplace_back(0, 0, 0);
  for (int ring = 1; ring <= 2; ++ring)
    for (int k = 0; k < valence; ++k)
      mesh.positions.emplace_back(ring * std::cos(2 * M_PI * k / valence),
                                  ring * std::sin(2 * M_PI * k / valence), 0.1 * ring);
  for (int k = 0; k + (open ? 1 : 0) < valence; ++k) {
    const int next = (k + 1) % valence;
    mesh.triangles.push_back({0, 1 + k, 1 + next});
    mesh.triangles.push_back({1 + k, 1 + valence + k, 1 + valence + next});
    mesh.triangles.push_back({1 + k, 1 + valence + next, 1 + next});
  }
  return mesh;
}

// Every inner vertex has six neighbours placed evenly about it.
Mesh Lattice(int side) {
  Mesh mesh;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) mesh.positions.emplace_back(x + 0.5 * y, std::sqrt(0.75) * y, 0);
  for (int y = 0; y + 1 < side; ++y)
    for (int x = 0; x + 1 < side; ++x) {
      const int a = y * side + x;
      mesh.triangles.push_back({a, a + 1, a + side});
      mesh.triangles.push_back({a + 1, a + side + 1, a + side});
    }
  return mesh;
}

Mesh Cap(int views, double half_angle) {
  const ViewpointMesh of_views =
      MakeViewpointMesh(test::CapViewpoints(views, half_angle, 2.0, 0.05), Subject{Vector3d::Zero(), 0.2});
  Mesh mesh;
  mesh.triangles = of_views.triangles;
  for (const auto& vertex : of_views.vertices) mesh.positions.push_back(vertex.position_in_world);
  return mesh;
}

// By name, what a limit must hold for: vertices of all valences inside and on rims, closed and open.
std::vector<std::pair<std::string, Mesh>> Meshes() {
  std::vector<std::pair<std::string, Mesh>> meshes{
      {"lattice", Lattice(7)}, {"cap", Cap(70, 0.5)}, {"sphere", Cap(70, M_PI)}, {"one triangle", Wheel(3)}};
  meshes.back().second.triangles.resize(1);
  meshes.emplace_back("tetrahedron", Mesh{{{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}},
                                          {{0, 1, 3}, {0, 2, 1}, {0, 3, 2}, {1, 2, 3}}});
  for (const int valence : {3, 4, 5, 6, 7, 12, 40})
    for (const bool open : {false, true})
      meshes.emplace_back("wheel of " + std::to_string(valence) + (open ? ", open" : ""),
                          Wheel(valence, open));
  return meshes;
}

// Places all over a triangle: its corners, edges, and among them some very near to a corner.
std::vector<Vector3d> Places() {
  std::vector<Vector3d> places;
  constexpr int kSteps = 12;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j) places.push_back(Vector3d(i, j, kSteps - i - j) / kSteps);
  for (const double near : {1e-2, 1e-4, 1e-8, 1e-12})
    for (int k = 0; k < 3; ++k)
      for (const double side : {0.0, 0.3, 1.0}) {
        Vector3d place;
        place(k) = 1 - near;
        place((k + 1) % 3) = near * side;
        place((k + 2) % 3) = near * (1 - side);
        places.push_back(place);
      }
  return places;
}

double WeightOf(const SparseWeights& weights, int vertex) {
  for (const auto& [of, weight] : weights)
    if (of == vertex) return weight;
  return 0;
}

TEST(BoxSpline, IsOneAltogetherAndNeverNegative) {
  for (const Vector3d& place : Places()) {
    double sum = 0, of_terms = 0;
    for (const double weight : BoxSplineWeights(place)) {
      EXPECT_GE(weight, 0);
      sum += weight;
    }
    for (const double term : QuarticBernstein(place)) of_terms += term;
    EXPECT_NEAR(sum, 1, 1e-13);
    EXPECT_NEAR(of_terms, 1, 1e-13);
  }
}

TEST(BoxSpline, AQuarticIsFoundFromItsValues) {
  std::array<double, kQuarticTerms> coefficients{}, values{};
  for (std::size_t i = 0; i < values.size(); ++i) coefficients[i] = std::sin(static_cast<double>(3 * i));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto& [a, b, c] = QuarticExponents()[i];
    const auto terms = QuarticBernstein(Vector3d(a, b, c) / 4);
    for (std::size_t k = 0; k < terms.size(); ++k) values[i] += coefficients[k] * terms[k];
  }
  const auto found = QuarticThrough(values);
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(found[i], coefficients[i], 1e-11) << i;
}

TEST(WeightSum, BeginsAnewAfterEachSum) {
  WeightSum sum;
  sum.Add(5, 0.25);
  sum.Add({{2, 1.0}, {5, 2.0}}, 0.5);
  EXPECT_EQ(sum.Take(), SparseWeights({{2, 0.5}, {5, 1.25}}));
  sum.Add(2, 1);
  EXPECT_EQ(sum.Take(), SparseWeights({{2, 1.0}}));
  EXPECT_TRUE(sum.Take().empty());
}

TEST(LimitSurface, WeightsArePositiveSumToOneAndReachTheTwoRing) {
  for (const SubdivisionRules rules : kBothRules)
    for (const auto& [name, mesh] : Meshes()) {
      const LimitSurface limit = mesh.Limit(rules);
      const auto topology = MakeTopology(static_cast<int>(mesh.positions.size()), mesh.triangles);
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        std::set<int> ring(mesh.triangles[t].begin(), mesh.triangles[t].end());
        for (const int corner : mesh.triangles[t])
          ring.insert(topology.neighbours[At(corner)].begin(), topology.neighbours[At(corner)].end());
        for (const Vector3d& place : Places()) {
          double sum = 0;
          for (const auto& [of, weight] : limit.Weights(static_cast<int>(t), place)) {
            ASSERT_GE(weight, -1e-14) << name << ", " << NameOf(rules) << ", at " << place.transpose();
            ASSERT_TRUE(ring.count(of) != 0 || std::abs(weight) < 1e-14) << name;
            sum += weight;
          }
          ASSERT_NEAR(sum, 1, 1e-12) << name << ", " << NameOf(rules) << ", at " << place.transpose();
        }
      }
    }
}

// Levels approach the limit, at all of their vertices. Each corner of a triangle of level k is a place of the
// limit; the fourth level's vertices lie between those of the third, and so on.
TEST(LimitSurface, IsWhereSubdivisionGoes) {
  for (const SubdivisionRules rules : kBothRules)
    for (const auto& [name, mesh] : Meshes()) {
      const LimitSurface limit = mesh.Limit(rules);
      SubdividedMesh level = SubdivideWeights(mesh.positions, mesh.Outward(), mesh.triangles, 0, rules);
      std::vector<Matrix3d> places(mesh.triangles.size(), Matrix3d::Identity());
      const int levels = mesh.triangles.size() > 60 ? 3 : 5;
      double last = 1, before = 1;
      for (int k = 1; k <= levels; ++k) {
        level = SubdivideOnce(level, rules, k == 1);
        std::vector<Matrix3d> finer;
        for (const Matrix3d& m : places) {
          const Vector3d a = m.col(0), b = m.col(1), c = m.col(2);
          const Vector3d ab = (a + b) / 2, bc = (b + c) / 2, ca = (c + a) / 2;
          for (const auto& part : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
            (finer.emplace_back() << part[0], part[1], part[2]).finished();
        }
        places = std::move(finer);
        double most = 0;
        for (std::size_t t = 0; t < level.triangles.size(); ++t)
          for (int corner = 0; corner < 3; ++corner)
            most = std::max(most, LargestDifference(limit.Weights(level.parent[t], places[t].col(corner)),
                                                    level.weights[At(level.triangles[t][At(corner)])]));
        before = last;
        last = most;
      }
      // A level leaves at most 5/8 of a difference, and a quarter where vertices are regular.
      EXPECT_LT(last, 0.7 * before + 1e-12) << name << ", " << NameOf(rules);
      EXPECT_LT(last, levels == 3 ? 0.1 : 0.03) << name << ", " << NameOf(rules);
    }
}

TEST(LimitSurface, AtVerticesItHasTheKnownValues) {
  for (const SubdivisionRules rules : kBothRules) {
    const Mesh lattice = Lattice(7);
    const LimitSurface regular = lattice.Limit(rules);
    const int middle = 3 * 7 + 3;
    int seen = 0;
    for (std::size_t t = 0; t < lattice.triangles.size(); ++t)
      for (int corner = 0; corner < 3; ++corner) {
        if (lattice.triangles[t][At(corner)] != middle) continue;
        ++seen;
        const SparseWeights at = regular.Weights(static_cast<int>(t), Vector3d::Unit(corner));
        EXPECT_NEAR(WeightOf(at, middle), 0.5, 1e-12);
        for (const int neighbour : {middle - 1, middle + 1, middle - 7, middle + 7, middle - 6, middle + 6})
          EXPECT_NEAR(WeightOf(at, neighbour), 1.0 / 12, 1e-12);
      }
    EXPECT_EQ(seen, 6);
  }
  for (const int valence : {3, 4, 5, 7, 12, 40}) {
    // Loop's limit: 1 - n w of the vertex, w of each neighbour; under Loop's rules from the mesh as it is.
    const double share = valence == 3 ? 1.0 / 5 : 1.0 / (2 * valence);
    const SparseWeights at = Wheel(valence).Limit(SubdivisionRules::kLoop).Weights(0, Vector3d::UnitX());
    EXPECT_NEAR(WeightOf(at, 0), 1 - valence * share, 1e-12) << valence;
    for (int k = 1; k <= valence; ++k) EXPECT_NEAR(WeightOf(at, k), share, 1e-12) << valence;
  }
}

TEST(LimitSurface, OnTheRimItIsLinearOrACubicSpline) {
  const Mesh mesh = Lattice(6);  // edge 2 to 3 is on the rim, in triangle (2, 3, 8)
  const auto found = std::ranges::find(mesh.triangles, Triangle{2, 3, 8});
  ASSERT_NE(found, mesh.triangles.end());
  const int t = static_cast<int>(found - mesh.triangles.begin());
  for (const double x : {0.0, 0.1, 0.25, 0.5, 0.8, 1.0}) {
    const Vector3d place(1 - x, x, 0);
    EXPECT_LT(
        LargestDifference(mesh.Limit(SubdivisionRules::kDelaunay).Weights(t, place), {{2, 1 - x}, {3, x}}),
        1e-12);
    const double y = 1 - x;
    EXPECT_LT(LargestDifference(mesh.Limit(SubdivisionRules::kLoop).Weights(t, place),
                                {{1, y * y * y / 6},
                                 {2, (4 - 6 * x * x + 3 * x * x * x) / 6},
                                 {3, (4 - 6 * y * y + 3 * y * y * y) / 6},
                                 {4, x * x * x / 6}}),
              1e-12)
        << x;
  }
}

// Across the edge (a, b) of the triangles (a, b, c) and (b, a, d), unfolded so that d = a + b - c: after enough
// levels the mesh around a place of the edge is regular, so there is no kink, however near an irregular end is.
TEST(LimitSurface, HasNoKinkAcrossAnyEdge) {
  for (const SubdivisionRules rules : kBothRules)
    for (const auto& [name, mesh] : Meshes()) {
      const LimitSurface limit = mesh.Limit(rules);
      const auto topology = MakeTopology(static_cast<int>(mesh.positions.size()), mesh.triangles);
      const auto corner_of = [&](int t, int vertex) {
        return std::ranges::find(mesh.triangles[At(t)], vertex) - mesh.triangles[At(t)].begin();
      };
      double most = 0, steepest = 0;
      for (const MeshEdge& edge : topology.edges) {
        if (edge.OnBoundary()) continue;
        for (const double from_share : {0.02, 0.13, 0.3, 0.5, 0.8, 0.97}) {
          const double step = 1e-4 * std::min(from_share, 1 - from_share);
          const auto at = [&](double beyond) {
            const int side = beyond < 0 ? 0 : 1;
            const double depth = std::abs(beyond), along = from_share - depth / 2;
            Vector3d place;
            place(corner_of(edge.triangle[At(side)], edge.from)) = along;
            place(corner_of(edge.triangle[At(side)], edge.to)) = 1 - along - depth;
            place(corner_of(edge.triangle[At(side)], edge.opposite[At(side)])) = depth;
            return limit.Weights(edge.triangle[At(side)], place);
          };
          std::map<int, double> kink, slope;
          for (const auto& [beyond, factor] : {std::pair(-2.0, 1.0), {-1.0, -1.0}, {1.0, -1.0}, {2.0, 1.0}})
            for (const auto& [of, weight] : at(beyond * step)) {
              kink[of] += factor * weight / step;
              if (beyond > 0) slope[of] += factor * weight / step;
            }
          for (const auto& [of, value] : kink) most = std::max(most, std::abs(value));
          for (const auto& [of, value] : slope) steepest = std::max(steepest, std::abs(value));
        }
      }
      EXPECT_LT(most, 0.01) << name << ", " << NameOf(rules);
      EXPECT_GT(steepest, mesh.triangles.size() > 1 ? 0.2 : -1.0) << name;
    }
}

// Around a vertex of any valence: along a curve through the vertex that is smooth in Loop's characteristic
// map, weights have no kink. The map itself is a limit: that of places that are an eigenvector of the star, so
// weights are compared with it to first order: they are c + g . x there, for one g all around.
TEST(LimitSurface, HasOneTangentPlaneAtAVertexOfAnyValence) {
  for (const SubdivisionRules rules : kBothRules)
    for (const int valence : {3, 4, 5, 7, 8}) {
      const Mesh mesh = Wheel(valence);
      const LimitSurface limit = mesh.Limit(rules);
      // The characteristic map: x = sum of weights times the places of the ring, to first order, since the
      // regular polygon is an eigenvector.
      const double near = std::ldexp(1.0, -9);
      Eigen::MatrixXd design(4 * valence, 3);
      std::vector<SparseWeights> at;
      for (int k = 0; k < valence; ++k)
        for (int i = 0; i < 4; ++i) {
          at.push_back(limit.Weights(3 * k, {1 - near, near * (1 - i / 4.0), near * i / 4.0}));
          Vector3d place = Vector3d::Zero();
          for (const auto& [of, weight] : at.back()) place += weight * mesh.positions[At(of)];
          design.row(4 * k + i) << 1, place.x(), place.y();
        }
      const double size = design.col(1).cwiseAbs().maxCoeff();
      const SparseWeights hub = limit.Weights(0, Vector3d::UnitX());
      for (int vertex = 0; vertex <= valence; ++vertex) {
        Eigen::VectorXd values(4 * valence);
        for (std::size_t i = 0; i < at.size(); ++i)
          values(static_cast<Eigen::Index>(i)) = WeightOf(at[i], vertex) - WeightOf(hub, vertex);
        const Eigen::VectorXd fit = design.colPivHouseholderQr().solve(values);
        const double off = (design * fit - values).cwiseAbs().maxCoeff();
        // What is not linear becomes less than linear: at this distance a few per cent.
        EXPECT_LT(off, 0.08 * size) << valence << ", " << NameOf(rules) << ", weight of " << vertex;
      }
    }
}

TEST(LimitPieces, AreTheLimitButForTheVeryCorner) {
  for (const SubdivisionRules rules : kBothRules)
    for (const auto& [name, mesh] : Meshes()) {
      const LimitSurface limit = mesh.Limit(rules);
      const LimitPieces pieces = MakeLimitPieces(limit);
      ASSERT_EQ(pieces.triangles.size(), mesh.triangles.size());
      double most = 0, most_elsewhere = 0;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const LimitPieces::OfTriangle& of = pieces.triangles[t];
        const auto compare = [&](const Vector3d& place) {
          const PlaceInPiece found = FindPiece(of.has_rings, place);
          const auto terms = QuarticBernstein(found.barycentric);
          SparseWeights weights;
          for (std::size_t i = 0; i < of.vertices.size(); ++i) {
            const LimitPieces::Piece& piece = pieces.pieces[of.first_piece[i] + At(found.piece)];
            double weight = 0;
            for (std::size_t k = 0; k < terms.size(); ++k) weight += terms[k] * static_cast<double>(piece[k]);
            weights.emplace_back(of.vertices[i], weight);
          }
          const double off = LargestDifference(weights, limit.Weights(static_cast<int>(t), place));
          const bool is_at_corner = place.maxCoeff() > 1 - std::ldexp(1.0, -LimitPieces::kRings - 1);
          (is_at_corner ? most : most_elsewhere) = std::max(is_at_corner ? most : most_elsewhere, off);
        };
        for (const Vector3d& place : Places()) compare(place);
        for (int i = 0; i <= 8; ++i)  // inside the last pieces
          for (int j = 0; i + j <= 8; ++j)
            for (int k = 0; k < 3; ++k) {
              const double share = std::ldexp(1.0, -LimitPieces::kRings - 1);
              Vector3d place;
              place(k) = 1 - share * (i + j) / 8.0;
              place((k + 1) % 3) = share * i / 8.0;
              place((k + 2) % 3) = share * j / 8.0;
              compare(place);
            }
      }
      EXPECT_LT(most_elsewhere, 2e-6) << name << ", " << NameOf(rules);  // floats
      // A rim's vertex of many neighbours is the worst there is.
      const bool is_inside = name.starts_with("wheel") && !name.ends_with("open");
      EXPECT_LT(most, is_inside ? 1.0 / 1800 : 1.0 / 255) << name << ", " << NameOf(rules);
    }
}

}  // namespace
}  // namespace ulf
