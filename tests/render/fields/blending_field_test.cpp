// Tests: render/fields/blending_field, render/fields/field_options, render/fields/make_field,
// render/fields/mesh_field, render/fields/lumigraph_field, render/fields/image_triangulation,
// render/fields/ray_cone.
#include "render/fields/blending_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <random>

#include "core/base/error.h"
#include "render/fields/field_options.h"
#include "render/fields/image_triangulation.h"
#include "render/fields/lumigraph_field.h"
#include "render/fields/make_field.h"
#include "render/fields/mesh_field.h"
#include "render/fields/ray_cone.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::blending_field_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::size_t At(int index) { return static_cast<std::size_t>(index); }

double Sum(const FieldSample& sample) {
  double sum = 0;
  for (const ViewWeight& entry : sample.weights) {
    EXPECT_GE(entry.weight, 0);
    sum += entry.weight;
  }
  return sum;
}

// Rays from V to points in the subject's sphere.
std::vector<Vector3d> RaysToSubject(const Vector3d& virtual_center, double radius, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-radius, radius);
  std::vector<Vector3d> rays;
  while (static_cast<int>(rays.size()) < count) {
    const Vector3d target(uniform(random), uniform(random), uniform(random));
    if (target.norm() < radius) rays.push_back((target - virtual_center).normalized());
  }
  return rays;
}

struct Arrangement {
  std::string name;
  std::vector<Vector3d> viewpoints;
};

std::vector<Arrangement> Arrangements() {
  return {{"cap", test::CapViewpoints(90, 0.7, 2.0, 0.03)},
          {"sphere", test::CapViewpoints(150, M_PI, 2.0, 0.03)},
          {"grid", test::GridViewpoints(9, 7, 0.15, 2.0)}};
}

FieldOptions Linear() { return {.kind = FieldKind::kLinear, .level = 0}; }
FieldOptions Subdivision(int level = 1) { return {.kind = FieldKind::kSubdivision, .level = level}; }

// V outside, inside (moved in twice and three times), on the shell.
const std::vector<double> kDistanceRatios{3.0, 1.4, 1.001, 1.0, 0.999, 0.5, 0.33};

TEST(MeshField, WeightsSumToOneInsideTheHull) {
  for (const Arrangement& arrangement : Arrangements()) {
    const auto scene = test::MakeScene({.viewpoints = arrangement.viewpoints, .width = 8, .height = 8});
    for (const FieldOptions& options : {Linear(), Subdivision(1), Subdivision(2)}) {
      const auto field = MakeField(scene, options);
      for (const double ratio : kDistanceRatios)
        for (const Vector3d& direction :
             {Vector3d(0.1, 0.05, 1), Vector3d(-0.12, 0.13, 1), Vector3d(0, 0, 1)}) {
          const Vector3d v = 2.0 * ratio * direction.normalized();
          const auto here = field->From(v);
          FieldSample sample;
          for (const Vector3d& ray : RaysToSubject(v, 0.1, 40, 5)) {
            here->Weights({.ray_in_world = ray, .point_in_world = Vector3d::Zero()}, sample);
            ASSERT_NEAR(Sum(sample), 1, 1e-5) << arrangement.name << ", distance ratio " << ratio;
            EXPECT_FALSE(sample.extrapolated) << arrangement.name << ", distance ratio " << ratio;
          }
        }
    }
  }
}

// The definition itself: intersect the line with every triangle, take the sheet that the ray enters from
// outside.
std::map<int, double> WeightsByDefinition(const ViewpointMesh& mesh, const Vector3d& v, const Vector3d& ray) {
  std::map<int, double> weights;
  for (const Triangle& t : mesh.triangles) {
    const Vector3d& a = mesh.vertices[At(t[0])].position_in_world;
    const Vector3d& b = mesh.vertices[At(t[1])].position_in_world;
    const Vector3d& c = mesh.vertices[At(t[2])].position_in_world;
    const Vector3d normal = (b - a).cross(c - a);
    if (!(ray.dot(normal) < 0)) continue;
    const double along = normal.dot(a - v) / normal.dot(ray);
    const Vector3d hit = v + along * ray;
    const double area = normal.squaredNorm();
    const double wa = (b - hit).cross(c - hit).dot(normal) / area;
    const double wb = (c - hit).cross(a - hit).dot(normal) / area;
    const double wc = (a - hit).cross(b - hit).dot(normal) / area;
    if (std::min({wa, wb, wc}) < -1e-12) continue;
    weights.clear();  // one crossing counts
    weights[mesh.vertices[At(t[0])].views.front()] += wa;
    weights[mesh.vertices[At(t[1])].views.front()] += wb;
    weights[mesh.vertices[At(t[2])].views.front()] += wc;
  }
  return weights;
}

TEST(MeshField, EqualsTheLineTriangleIntersection) {
  for (const Arrangement& arrangement : Arrangements()) {
    const auto scene = test::MakeScene({.viewpoints = arrangement.viewpoints, .width = 8, .height = 8});
    const auto field = MakeField(scene, Linear());
    for (const double ratio : {3.0, 1.4, 0.5, 0.33}) {
      const Vector3d v = 2.0 * ratio * Vector3d(0.11, 0.07, 1).normalized();
      const auto here = field->From(v);
      FieldSample sample;
      for (const Vector3d& ray : RaysToSubject(v, 0.3, 60, 7)) {
        here->Weights({.ray_in_world = ray, .point_in_world = Vector3d::Zero()}, sample);
        auto expected = WeightsByDefinition(scene->mesh, v, ray);
        EXPECT_EQ(expected.empty(), sample.extrapolated) << arrangement.name << ", distance ratio " << ratio;
        if (sample.extrapolated) continue;
        for (const ViewWeight& entry : sample.weights)
          EXPECT_NEAR(entry.weight, expected[entry.view], 1e-9)
              << arrangement.name << ", distance ratio " << ratio;
      }
    }
  }
}

TEST(MeshField, CandidatesOfAConeHoldEveryCrossing) {
  const auto scene =
      test::MakeScene({.viewpoints = test::CapViewpoints(90, 0.7, 2.0, 0.03), .width = 8, .height = 8});
  const auto field = MakeField(scene, Subdivision());
  for (const double ratio : {1.4, 1.0, 0.5}) {
    const Vector3d v = 2.0 * ratio * Vector3d(0.1, -0.08, 1).normalized();
    const auto here = field->From(v);
    const Vector3d axis = -v.normalized();
    std::mt19937 random(4);
    std::normal_distribution<double> normal(0, 0.1);
    const auto candidates = here->CandidatesInCone(axis, 0.25);
    EXPECT_LT(candidates.size(), static_cast<MeshField*>(field.get())->field_mesh().triangles.size());
    FieldSample all, some;
    for (int i = 0; i < 200; ++i) {
      const Vector3d ray = (axis + Vector3d(normal(random), normal(random), normal(random))).normalized();
      if (std::acos(ray.dot(axis)) > 0.25) continue;
      here->Weights({ray, Vector3d::Zero(), nullptr}, all);
      here->Weights({ray, Vector3d::Zero(), &candidates}, some);
      ASSERT_EQ(all.weights.size(), some.weights.size());
      for (std::size_t k = 0; k < all.weights.size(); ++k)
        EXPECT_EQ(all.weights[k].weight, some.weights[k].weight);
    }
  }
}

TEST(MeshField, ViewsBehindTheSubjectHaveNoWeight) {
  const auto scene =
      test::MakeScene({.viewpoints = test::CapViewpoints(200, M_PI, 2.0), .width = 8, .height = 8});
  const auto field = MakeField(scene, Subdivision());
  for (const double ratio : kDistanceRatios) {
    const Vector3d v(0, 0, 2.0 * ratio);
    const auto here = field->From(v);
    FieldSample sample;
    for (const Vector3d& ray : RaysToSubject(v, 0.3, 50, 2)) {
      here->Weights({.ray_in_world = ray, .point_in_world = Vector3d::Zero()}, sample);
      for (const ViewWeight& entry : sample.weights)
        EXPECT_GT(scene->views[At(entry.view)].center_in_world.z(), 0) << ratio;
    }
  }
}

TEST(MeshField, OnARecordedViewpointThatViewHasAllWeight) {
  for (const Arrangement& arrangement : Arrangements()) {
    const auto scene = test::MakeScene({.viewpoints = arrangement.viewpoints, .width = 8, .height = 8});
    ASSERT_EQ(scene->mesh.smoothing_rounds, 0) << arrangement.name;
    const auto field = MakeField(scene, Linear());
    for (std::size_t i = 0; i < scene->views.size(); i += 7) {
      const auto here = field->From(scene->views[i].center_in_world);
      FieldSample sample;
      for (const Vector3d& ray : RaysToSubject(scene->views[i].center_in_world, 0.5, 30, 3)) {
        here->Weights({.ray_in_world = ray, .point_in_world = Vector3d::Zero()}, sample);
        double own = 0;
        for (const ViewWeight& entry : sample.weights)
          if (entry.view == static_cast<int>(i)) own += entry.weight;
        EXPECT_GT(own, 0.997) << arrangement.name << ", view " << i;
      }
    }
  }
}

// No popping: weights move with V, through the shell too.
TEST(MeshField, WeightsAreContinuousInTheViewpoint) {
  const auto scene =
      test::MakeScene({.viewpoints = test::CapViewpoints(120, 0.8, 2.0, 0.02), .width = 8, .height = 8});
  for (const FieldOptions& options : {Linear(), Subdivision()}) {
    const auto field = MakeField(scene, options);
    std::map<int, double> before;
    double largest_step = 0;
    constexpr int kSteps = 2000;
    for (int i = 0; i <= kSteps; ++i) {
      const double s = static_cast<double>(i) / kSteps;
      // Sideways over many triangles while moving in from outside through the shell.
      const Vector3d v = (3.0 - 2.0 * s) * Vector3d(-0.3 + 0.6 * s, 0.2 - 0.3 * s, 1).normalized();
      FieldSample sample;
      const Vector3d ray = (Vector3d(0.1, -0.05, 0.02) - v).normalized();
      field->From(v)->Weights({.ray_in_world = ray, .point_in_world = Vector3d::Zero()}, sample);
      std::map<int, double> now;
      for (const ViewWeight& entry : sample.weights) now[entry.view] = entry.weight;
      if (i > 0) {
        std::map<int, double> difference = now;
        for (const auto& [view, weight] : before) difference[view] -= weight;
        for (const auto& [view, change] : difference) largest_step = std::max(largest_step, std::abs(change));
      }
      before = now;
    }
    EXPECT_LT(largest_step, 0.02);
  }
}

TEST(MeshField, OutsideTheHullTheRimServesAndSaysSo) {
  for (const auto& viewpoints :
       {test::CapViewpoints(90, 0.4, 2.0, 0.03), test::GridViewpoints(9, 7, 0.15, 2.0)}) {
    const auto scene = test::MakeScene({.viewpoints = viewpoints, .width = 8, .height = 8});
    for (const FieldOptions& options : {Linear(), Subdivision()}) {
      const auto field = MakeField(scene, options);
      for (const double ratio : {1.5, 1.0, 0.6})
        for (int i = 0; i < 16; ++i) {
          const double a = 2 * M_PI * i / 16;
          const Vector3d v = 2.0 * ratio * Vector3d(0.8 * std::cos(a), 0.8 * std::sin(a), 1).normalized();
          FieldSample sample;
          field->From(v)->Weights({.ray_in_world = -v.normalized(), .point_in_world = Vector3d::Zero()},
                                  sample);
          ASSERT_NEAR(Sum(sample), 1, 1e-5) << ratio << " " << i;
          EXPECT_TRUE(sample.extrapolated);
          EXPECT_LE(sample.confidence, kExtrapolatedConfidence);
          // Only views near that side of the rim weigh.
          for (const ViewWeight& entry : sample.weights)
            EXPECT_GT(scene->views[At(entry.view)].center_in_world.head<2>().dot(v.head<2>()), 0);
        }
    }
  }
}

TEST(MeshField, LeavingTheHullIsContinuous) {
  const auto scene =
      test::MakeScene({.viewpoints = test::GridViewpoints(9, 7, 0.15, 2.0), .width = 8, .height = 8});
  const auto field = MakeField(scene, Subdivision());
  std::map<int, double> before;
  for (int i = 0; i <= 1000; ++i) {
    const Vector3d v(0.4 + 0.0004 * i, 0.1, 2.2);  // the rim is at x = 0.6
    FieldSample sample;
    field->From(v)->Weights({.ray_in_world = -v.normalized(), .point_in_world = Vector3d::Zero()}, sample);
    std::map<int, double> now;
    for (const ViewWeight& entry : sample.weights) now[entry.view] = entry.weight;
    if (i > 0) {
      for (const auto& [view, weight] : now) ASSERT_NEAR(weight, before[view], 0.02) << "x = " << v.x();
    }
    before = now;
  }
}

// ---- Lumigraph and nearest ----

TEST(RayCone, GivesBarycentricCoordinatesOfRays) {
  Matrix3d corners;
  corners << 1, 0, -1, 0, 2, -1, 4, 3, 5;  // columns
  const Matrix3d cone = ConeFromRay(corners);
  const Vector3d share(0.2, 0.5, 0.3);
  EXPECT_LT((*Barycentric(cone, 7 * (corners * share)) - share).norm(), 1e-12);
  EXPECT_LT((*Barycentric(cone, corners.col(1)) - Vector3d(0, 1, 0)).norm(), 1e-12)
      << "a corner belongs to it";
  EXPECT_FALSE(Barycentric(cone, corners * Vector3d(-0.1, 0.6, 0.5)));
  EXPECT_FALSE(Barycentric(cone, -(corners * share))) << "behind";
  Matrix3d edge_on = corners;
  edge_on.col(2) = corners.col(0) + corners.col(1);
  EXPECT_TRUE(ConeFromRay(edge_on).isZero(0));
  EXPECT_FALSE(Barycentric(ConeFromRay(edge_on), corners.col(0)));
}

TEST(RayCone, MayMeetIsFalseOnlyBesideTheTriangle) {
  Matrix3d corners;
  corners << 1, 0, -1, 0, 2, -1, 4, 3, 5;
  const Matrix3d cone = ConeFromRay(corners);
  const Vector3d axis = Vector3d(3, 0, 1).normalized();
  EXPECT_FALSE(MayMeet(cone, axis, 0.1));
  EXPECT_TRUE(MayMeet(cone, axis, 1.4)) << "a wide cone reaches it";
  EXPECT_TRUE(MayMeet(cone, (corners * Vector3d(0.3, 0.3, 0.4)).normalized(), 0.0));
  EXPECT_FALSE(MayMeet(Matrix3d::Zero(), axis, 1.4)) << "seen edge-on";
}

TEST(LumigraphField, SumsToOneOverAtMostKViews) {
  for (const Arrangement& arrangement : Arrangements()) {
    const auto scene = test::MakeScene({.viewpoints = arrangement.viewpoints});
    for (const int k : {1, 4, 8}) {
      const auto field = MakeField(scene, {.kind = FieldKind::kLumigraph, .lumigraph_k = k});
      const Vector3d v(0.21, 0.1, 2.5);
      const auto here = field->From(v);
      FieldSample sample;
      for (int i = 0; i < 20; ++i) {
        const Vector3d point(0.05 * i - 0.5, 0.02 * i - 0.2, 0);
        here->Weights({.ray_in_world = (point - v).normalized(), .point_in_world = point}, sample);
        ASSERT_FALSE(sample.weights.empty());
        EXPECT_LE(sample.weights.size(), At(k));
        EXPECT_NEAR(Sum(sample), 1, 1e-12);
        for (const ViewWeight& entry : sample.weights)
          EXPECT_TRUE(scene->views[At(entry.view)].ProjectVisible(point));
      }
    }
  }
}

TEST(LumigraphField, DistanceCostsAsMuchAsAsked) {
  std::shared_ptr<const RenderScene> scene =
      test::MakeScene({.viewpoints = test::CapViewpoints(60, 0.5, 2.0, 0.4)});
  const auto mean_distance = [&](double resolution) {
    FieldSample sample;
    MakeField(scene,
              {.kind = FieldKind::kLumigraphPerPixel, .lumigraph_k = 8, .lumigraph_resolution = resolution})
        ->From({0, 0, 1.5})
        ->Weights({-Vector3d::UnitZ(), Vector3d::Zero()}, sample);
    double sum = 0;
    for (const ViewWeight& entry : sample.weights)
      sum += entry.weight * scene->views[At(entry.view)].center_in_world.norm();
    return sum;
  };
  EXPECT_GT(mean_distance(0), 1.05 * mean_distance(1));
}

TEST(LumigraphField, SplitsTheImageInTheAskedTriangles) {
  const auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(30, 0.5, 2.0)});
  const CameraModel camera = CameraModel::Pinhole(320, 240, 200);
  const Rigid3 pose = LookAt({0, 0, 1.5}, {0, 0, 0}, Vector3d::UnitY());
  for (const int wanted : {500, 2000, 6000}) {
    const auto image = TriangulateLumigraph(*scene, camera, pose, [](const Eigen::Vector2d&) { return 1.5; },
                                            {.lumigraph_k = 4, .lumigraph_triangles = wanted});
    EXPECT_NEAR(static_cast<double>(image.triangles.size()) / wanted, 1, 0.12);
  }
}

TEST(LumigraphWeights, HandleEdgeCases) {
  using testing::DoubleNear;
  EXPECT_TRUE(LumigraphWeights({}, 4).empty());
  EXPECT_NEAR(LumigraphWeights({{3, 0.2}}, 4).front().weight, 1, 1e-12);
  // A zero penalty takes all.
  const auto own = LumigraphWeights({{0, 0.1}, {1, 0.0}, {2, 0.2}}, 2);
  ASSERT_EQ(own.size(), 1u);
  EXPECT_EQ(own.front().view, 1);
  // Equal penalties weigh the same, with and without a next one.
  for (const std::size_t k : {2u, 3u, 4u})
    for (const ViewWeight& entry : LumigraphWeights({{0, 0.1}, {1, 0.1}, {2, 0.1}, {3, 0.1}}, k))
      EXPECT_NEAR(entry.weight, 1.0 / static_cast<double>(k), 1e-9) << k;
  // The formula: threshold 0.4, (1 - p / 0.4) / p.
  const auto weights = LumigraphWeights({{0, 0.1}, {1, 0.2}, {2, 0.4}}, 2);
  ASSERT_EQ(weights.size(), 2u);
  EXPECT_NEAR(weights[0].weight, 7.5 / 10, 1e-12);
  EXPECT_NEAR(weights[1].weight, 2.5 / 10, 1e-12);
}

TEST(NearestField, IsTheNearestThatSees) {
  const auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(5, 5, 0.2, 2.0)});
  const auto field = MakeField(scene, {.kind = FieldKind::kNearest});
  const Vector3d v(0.19, 0.22, 2.1);
  FieldSample sample;
  field->From(v)->Weights({.ray_in_world = -v.normalized(), .point_in_world = Vector3d::Zero()}, sample);
  ASSERT_EQ(sample.weights.size(), 1u);
  EXPECT_EQ(sample.weights.front().view, 3 * 5 + 3);
  field->From(v)->Weights({.ray_in_world = -v.normalized(), .point_in_world = Vector3d(50, 0, 0)}, sample);
  EXPECT_TRUE(sample.weights.empty());
}

TEST(Fields, FallBackWhereViewpointsDoNotAllowOne) {
  const auto used = [](const std::vector<Vector3d>& viewpoints, FieldKind asked) {
    const ViewpointMesh mesh = MakeViewpointMesh(viewpoints, {Vector3d::Zero(), 0.3});
    return FieldThatServes({.kind = asked}, mesh).kind;
  };
  EXPECT_EQ(used({{0, 0, 2}}, FieldKind::kSubdivision), FieldKind::kNearest);
  EXPECT_EQ(used({{0, 0, 2}}, FieldKind::kLumigraph), FieldKind::kNearest);
  EXPECT_EQ(used(std::vector<Vector3d>(9, Vector3d(0, 0, 2)), FieldKind::kLinear), FieldKind::kNearest);
  EXPECT_EQ(used({{0, 0, 2}, {0.3, 0, 2}}, FieldKind::kSubdivision), FieldKind::kLumigraph);
  EXPECT_EQ(used(test::RingViewpoints(47, 0, 2, 0.01), FieldKind::kSubdivision), FieldKind::kLumigraph);
  EXPECT_EQ(used(test::RingViewpoints(47, 0, 2, 0.01), FieldKind::kNearest), FieldKind::kNearest);
  EXPECT_EQ(used(test::CapViewpoints(60, 0.6, 2), FieldKind::kSubdivision), FieldKind::kSubdivision);
}

// One more than a simplex of the viewpoints has: it is the threshold of the others.
TEST(Fields, LumigraphViewsSuitTheViewpoints) {
  const auto views = [](const std::vector<Vector3d>& viewpoints, int asked) {
    const ViewpointMesh mesh = MakeViewpointMesh(viewpoints, {Vector3d::Zero(), 0.3});
    return FieldThatServes({.kind = FieldKind::kLumigraph, .lumigraph_k = asked}, mesh).lumigraph_k;
  };
  EXPECT_EQ(views(test::CapViewpoints(60, 0.6, 2), 0), 4);
  EXPECT_EQ(views(test::RingViewpoints(47, 0, 2, 0.01), 0), 3);
  EXPECT_EQ(views(test::GridViewpoints(14, 1, 0.1, 2), 0), 3);
  EXPECT_EQ(views(test::RingViewpoints(47, 0, 2, 0.01), 6), 6);
}

TEST(Fields, NamesRoundTripAndUnknownOnesAreListed) {
  for (const FieldKind kind : {FieldKind::kLinear, FieldKind::kSubdivision, FieldKind::kLumigraph,
                               FieldKind::kLumigraphPerPixel, FieldKind::kNearest})
    EXPECT_EQ(FieldFromName(FieldName(kind)), kind);
  EXPECT_THAT([&] { FieldFromName("bicubic"); },
              testing::ThrowsMessage<Refusal>(testing::HasSubstr("subdivision")));
}

}  // namespace
}  // namespace ulf::blending_field_test
