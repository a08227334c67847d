// Tests: render/stereo/plane_sweep, render/stereo/depth_range, render/stereo/view_selection,
// render/stereo/depth_fusion, render/stereo/tetrahedra, render/stereo/surface_cut.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>

#include "render/stereo/depth_fusion.h"
#include "render/stereo/depth_range.h"
#include "render/stereo/plane_sweep.h"
#include "render/stereo/surface_cut.h"
#include "render/stereo/tetrahedra.h"
#include "render/stereo/view_selection.h"
#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"

namespace ulf::stereo_test {
namespace {

using Eigen::Vector3d;
using test::Drawn;
using test::Mottled;
using test::Patch;
using test::Plain;
using testing::ElementsAre;
using testing::IsEmpty;

// Views side by side around the origin, which look along +z at what is three away.
std::vector<Drawn> Photographs(const std::vector<Patch>& patches, float gain_step = 0) {
  std::vector<Drawn> photographs;
  for (const auto& [x, y] : {std::pair{0., 0.}, {0.3, 0.}, {-0.3, 0.}, {0., 0.3}, {0., -0.3}, {0.2, 0.2}}) {
    const float n = static_cast<float>(photographs.size());
    photographs.push_back(
        Draw(patches, {x, y, 0}, {0, 0, 3}, 120, 90, 110, 1 - gain_step * n, 40 * gain_step * n));
  }
  return photographs;
}

DepthMap Sweep(const std::vector<Drawn>& photographs, double nearest = 1.5, double farthest = 12) {
  std::vector<const StereoView*> neighbours;
  for (std::size_t i = 1; i < photographs.size(); ++i) neighbours.push_back(&photographs[i].view);
  return SweepPlanes(photographs[0].view, neighbours,
                     PixelSpacedRange(photographs[0].view, neighbours, nearest, farthest));
}

double PlaneStep(const std::vector<Drawn>& photographs) {
  std::vector<const StereoView*> neighbours;
  for (std::size_t i = 1; i < photographs.size(); ++i) neighbours.push_back(&photographs[i].view);
  const InverseDepthRange range = PixelSpacedRange(photographs[0].view, neighbours, 1.5, 12);
  return (range.most - range.least) / (range.planes - 1);
}

// Errors of inverse depth in planes of the sweep, away from the picture's edge.
std::vector<double> ErrorsInPlanes(const std::vector<Drawn>& photographs, const DepthMap& map) {
  std::vector<double> errors;
  for (int y = 5; y < map.depth.rows - 5; ++y)
    for (int x = 5; x < map.depth.cols - 5; ++x)
      if (photographs[0].depth.at<float>(y, x) > 0)
        errors.push_back(std::abs(1 / map.depth.at<float>(y, x) - 1 / photographs[0].depth.at<float>(y, x)) /
                         PlaneStep(photographs));
  std::sort(errors.begin(), errors.end());
  return errors;
}

double At(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

Patch Wall(double depth, std::function<float(double, double)> grey, double tilt = 0) {
  return {{-8, -6, depth - 8 * tilt}, {16, 0, 16 * tilt}, {0, 12, 0}, std::move(grey)};
}

TEST(PlaneSweep, FindsATiltedPlaneBetweenSweptPlanes) {
  for (const auto& [tilt, seed] : {std::pair{0.0, 1u}, {0.3, 2u}, {-0.6, 3u}}) {
    const auto photographs = Photographs({Wall(3, Mottled(0.02, seed), tilt)});
    const auto errors = ErrorsInPlanes(photographs, Sweep(photographs));
    EXPECT_LT(At(errors, 0.5), 0.12) << "tilt " << tilt << ", seed " << seed;
    EXPECT_LT(At(errors, 0.95), 0.5) << "tilt " << tilt << ", seed " << seed;
  }
}

TEST(PlaneSweep, DoesNotAskHowPhotographsWereExposed) {
  const std::vector<Patch> wall{Wall(3, Mottled(0.02, 3), 0.3)};
  const auto photographs = Photographs(wall, 0.12f);
  ASSERT_GT(std::abs(cv::mean(photographs[5].view.grey)[0] - cv::mean(photographs[0].view.grey)[0]), 20);
  const auto errors = ErrorsInPlanes(photographs, Sweep(photographs));
  EXPECT_LT(At(errors, 0.5), 0.12);
  EXPECT_LT(At(errors, 0.95), 0.5);
}

// Beside a near board half of the neighbours see the board in place of the wall.
TEST(PlaneSweep, BetterHalfOfNeighboursSeesPastOccluders) {
  const auto photographs =
      Photographs({Wall(4, Mottled(0.02, 4)), {{-0.4, -0.4, 2}, {0.8, 0, 0}, {0, 0.8, 0}, Mottled(0.2, 5)}});
  const DepthMap map = Sweep(photographs);
  const auto errors = ErrorsInPlanes(photographs, map);
  EXPECT_LT(At(errors, 0.90), 0.5);
  EXPECT_LT(At(errors, 0.96), 1.0);
  EXPECT_NEAR(map.depth.at<float>(45, 60), 2, 0.05);
}

// A plain wall with a painted frame: what lies between has no texture of its own, and must not come forward.
TEST(PlaneSweep, APlainWallIsWhereItsRimIs) {
  const auto frame = [mottled = Mottled(0.02, 6)](double u, double v) {
    return std::max(std::abs(u - 0.5), std::abs(v - 0.5)) < 0.07 ? 120.0f : mottled(u, v);
  };
  const auto photographs = Photographs({Wall(3, frame)});
  const DepthMap map = Sweep(photographs);
  for (int y = 35; y < 55; ++y)
    for (int x = 45; x < 75; ++x) EXPECT_NEAR(map.depth.at<float>(y, x), 3, 0.25) << x << ", " << y;
}

TEST(DepthRange, KeepsWhatIsThereAndLeavesOutWhatIsNot) {
  const auto photographs =
      Photographs({Wall(6, Mottled(0.02, 7)), {{-0.5, -0.5, 2.5}, {1, 0, 0}, {0, 1, 0}, Mottled(0.2, 8)}});
  std::vector<const StereoView*> neighbours;
  for (std::size_t i = 1; i < photographs.size(); ++i) neighbours.push_back(&photographs[i].view);
  const InverseDepthRange range = FindRange(photographs[0].view, neighbours, 3);
  EXPECT_GT(range.most, 1 / 2.5);
  EXPECT_LT(range.most, 1 / 1.5);
  EXPECT_LT(range.least, 1 / 6.0);
  EXPECT_GT(range.least, 1 / 20.0);
}

// A wall and a post before it, 720 pixels wide; the post takes 30 of them.
std::vector<Drawn> DrawWallAndPost() {
  constexpr int kWidth = 720, kHeight = 200, kPostPx = 30;
  constexpr double kFocalPx = 660, kPostDepth = 1.3;
  const std::vector<Patch> patches{
      Wall(4, Mottled(0.01, 1)),
      {{0.1, -3, kPostDepth}, {kPostPx * kPostDepth / kFocalPx, 0, 0}, {0, 6, 0}, Mottled(0.02, 3)}};
  std::vector<Drawn> photographs;
  for (const auto& [x, y] : {std::pair{0., 0.}, {0.15, 0.}, {-0.15, 0.}, {0., 0.1}, {0.1, -0.1}})
    photographs.push_back(Draw(patches, {x, y, 0}, {0, 0, 3}, kWidth, kHeight, kFocalPx));
  return photographs;
}

const std::vector<Drawn>& WallAndPost() {
  static const std::vector<Drawn> photographs = DrawWallAndPost();
  return photographs;
}

// The first sweep sees photographs of this size at a quarter, and looks for surfaces at an eighth: four
// pixels of a post are left there. Of one of 18 pixels nothing remains.
TEST(DepthRange, HoldsAThinPostOfALargePhotograph) {
  const auto& photographs = WallAndPost();
  std::vector<const StereoView*> neighbours;
  for (std::size_t i = 1; i < photographs.size(); ++i) neighbours.push_back(&photographs[i].view);
  const InverseDepthRange range = FindRange(photographs[0].view, neighbours, 3);
  EXPECT_GT(range.most, 1 / 1.3) << "the post";
  EXPECT_LT(range.least, 1 / 4.0) << "the wall";
}

// Whoever waits for a sweep that is given up waits no longer for the sweeps before it.
TEST(DepthRange, CancellingReturnsAtOnce) {
  const auto& photographs = WallAndPost();
  const StereoView& view = photographs[0].view;
  std::vector<const StereoView*> neighbours;
  for (std::size_t i = 1; i < photographs.size(); ++i) neighbours.push_back(&photographs[i].view);
  const std::atomic<bool> given_up = true;
  const InverseDepthRange range = FindRange(view, neighbours, 3, {.given_up = &given_up});
  const DepthRangeOptions options;
  EXPECT_DOUBLE_EQ(range.most, 1 / (options.nearest * 3)) << "nothing was swept";
  EXPECT_DOUBLE_EQ(range.least, 1 / (options.farthest * 3));
  const SweepOptions sweep{.given_up = &given_up};
  EXPECT_EQ(PlanesNearSurfaces(view, neighbours, range, sweep).Share(), 0);
  EXPECT_TRUE(SweepPlanes(view, neighbours, range, sweep).depth.empty());
}

TEST(DepthRange, DepthPerPixelGrowsAsViewsMoveCloser) {
  const auto view_at = [](double x) { return test::Draw({}, {x, 0, 0}, {x, 0, 3}, 120, 90, 110).view; };
  const StereoView view = view_at(0), near = view_at(0.03), far = view_at(0.3);
  // z^2 / (f b).
  EXPECT_NEAR(DepthStepOfPixel(view, {&near, &far}, 3), 9 / (110 * 0.3), 1e-3);
  EXPECT_NEAR(DepthStepOfPixel(view, {&near}, 3), 9 / (110 * 0.03), 1e-2);
  EXPECT_TRUE(std::isinf(DepthStepOfPixel(view, {&view}, 3)));
}

// ---- Which views ----

TEST(ViewSelection, TakesParallaxFromAllSides) {
  std::vector<StereoView> views;
  for (int y = -4; y <= 4; ++y)
    for (int x = -4; x <= 4; ++x)
      views.push_back(test::Draw({}, {0.1 * x, 0.1 * y, 0}, {0, 0, 2}, 12, 9, 10).view);
  const Subject subject{{0, 0, 2}, 0.5};
  const auto neighbours = NeighboursOf(40, views, subject, 8);
  ASSERT_EQ(neighbours.size(), 8u);
  Vector3d sum = Vector3d::Zero();
  for (const int other : neighbours) {
    const double apart = views[static_cast<std::size_t>(other)].center_in_world.norm();
    EXPECT_GT(apart, 0.15);
    sum += views[static_cast<std::size_t>(other)].center_in_world / apart;
  }
  EXPECT_LT(sum.norm(), 2.5);
}

TEST(ViewSelection, SkipsCoincidentAndOppositeViews) {
  const Subject subject{{0, 0, 2}, 0.5};
  std::vector<StereoView> views;
  for (int i = 0; i < 3; ++i) views.push_back(test::Draw({}, {0, 0, 0}, {0.1 * i, 0, 2}, 12, 9, 10).view);
  views.push_back(test::Draw({}, {0, 0, 4}, {0, 0, 2}, 12, 9, 10).view);
  for (int i = 0; i < 4; ++i) EXPECT_THAT(NeighboursOf(i, views, subject, 8), IsEmpty()) << i;
}

TEST(ViewSelection, SpreadsOverAllViews) {
  std::vector<StereoView> views;
  for (int i = 0; i < 50; ++i) views.push_back(test::Draw({}, {0.02 * i, 0, 0}, {0.5, 0, 2}, 12, 9, 10).view);
  const Subject subject{{0.5, 0, 2}, 0.5};
  const auto chosen = SpreadViews(views, subject, 5);
  ASSERT_EQ(chosen.size(), 5u);
  EXPECT_EQ(chosen.front(), 0);
  EXPECT_EQ(chosen.back(), 49);
  for (std::size_t i = 1; i < chosen.size(); ++i) EXPECT_LE(chosen[i] - chosen[i - 1], 15);
  EXPECT_EQ(SpreadViews(views, subject, 60).size(), 50u);
}

// ---- Fusion ----

std::vector<std::vector<int>> Everyone(std::size_t views) {
  std::vector<std::vector<int>> others(views);
  for (std::size_t i = 0; i < views; ++i)
    for (std::size_t j = 0; j < views; ++j)
      if (i != j) others[i].push_back(static_cast<int>(j));
  return others;
}

std::vector<ViewDepth> TrueDepths(const std::vector<Drawn>& photographs) {
  std::vector<ViewDepth> maps;
  for (const Drawn& drawn : photographs)
    maps.push_back({drawn.view, drawn.depth.clone(), PlaneStep(photographs)});
  return maps;
}

TEST(DepthFusion, KeepsOnlyWhatOtherViewsConfirm) {
  const auto photographs = Photographs({Wall(4, Plain(100))});
  auto maps = TrueDepths(photographs);
  const cv::Rect wrong(50, 40, 6, 5);
  maps[0].depth(wrong) = 2.0f;  // in front of the wall: others see through it
  maps[1].depth(wrong) = 9.0f;  // behind it
  KeepConsistentDepths(maps, Everyone(maps.size()), {});
  EXPECT_EQ(cv::countNonZero(maps[0].depth(wrong)), 0);
  EXPECT_EQ(cv::countNonZero(maps[1].depth(wrong)), 0);
  EXPECT_GT(cv::countNonZero(maps[0].depth), 0.9 * static_cast<double>(maps[0].depth.total()));
}

TEST(DepthFusion, TakesTheMeanOfWhatAgrees) {
  const auto photographs = Photographs({Wall(4, Plain(100))});
  auto maps = TrueDepths(photographs);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.2 * maps[0].plane_step);
  for (ViewDepth& map : maps)
    for (float& depth : cv::Mat_<float>(map.depth))
      depth = static_cast<float>(1 / (1 / depth + noise(random)));
  const auto error = [&](const cv::Mat& depth) {
    double sum = 0;
    for (int y = 10; y < 80; ++y)
      for (int x = 10; x < 110; ++x)
        sum += std::pow(depth.at<float>(y, x) - photographs[0].depth.at<float>(y, x), 2);
    return std::sqrt(sum);
  };
  const double before = error(maps[0].depth);
  KeepConsistentDepths(maps, Everyone(maps.size()), {});
  EXPECT_LT(error(maps[0].depth), 0.6 * before);
}

TEST(DepthFusion, MakesOnePointOfWhatSeveralViewsSaw) {
  const auto photographs = Photographs({Wall(4, Plain(100))});
  const auto maps = TrueDepths(photographs);
  const auto points = FusePoints(maps, Everyone(maps.size()), {.spacing_px = 1});
  const auto fewer = FusePoints(maps, Everyone(maps.size()), {.spacing_px = 4});
  EXPECT_LT(points.size(), photographs[0].depth.total());
  EXPECT_LT(fewer.size(), 0.2 * static_cast<double>(points.size()));
  double views = 0;
  for (const FusedPoint& point : points) {
    EXPECT_NEAR(point.position_in_world.z(), 4, 1e-4);
    views += static_cast<double>(point.seen_by.size());
  }
  EXPECT_GT(views / static_cast<double>(points.size()), 4);
}

// ---- The surface ----

TEST(Tetrahedra, FillTheHullAndKnowTheirNeighbours) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(0, 1);
  std::vector<Vector3d> points;
  for (int x : {0, 1})
    for (int y : {0, 1})
      for (int z : {0, 1}) points.emplace_back(x, y, z);
  for (int i = 0; i < 200; ++i) points.emplace_back(any(random), any(random), any(random));
  points.push_back(points[20]);
  std::vector<std::uint32_t> number;
  const Tetrahedra space = DelaunayTetrahedra(points, &number);
  ASSERT_EQ(space.points.size(), points.size() - 1);
  EXPECT_EQ(number.back(), number[20]);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(space.points[number[i]], points[i]);
  double volume = 0;
  for (std::uint32_t cell = 0; cell < space.corners.size(); ++cell) {
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_EQ(std::count(space.neighbours[space.neighbours[cell][k]].begin(),
                           space.neighbours[space.neighbours[cell][k]].end(), cell),
                1);
    if (space.Outer(cell)) continue;
    const auto& of = space.corners[cell];
    const Vector3d a = space.points[of[0]];
    const double six =
        (space.points[of[1]] - a).dot((space.points[of[2]] - a).cross(space.points[of[3]] - a));
    EXPECT_GT(six, 0);
    volume += six / 6;
  }
  EXPECT_NEAR(volume, 1, 1e-9);
  EXPECT_THAT(DelaunayTetrahedra({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, nullptr).corners, IsEmpty());
}

// Points of a unit sphere seen from cameras around it, none of which looks at the lower side.
struct SeenSphere {
  std::vector<FusedPoint> points;
  std::vector<Vector3d> centers;
};
SeenSphere MakeSeenSphere(double noise, unsigned seed) {
  SeenSphere sphere;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  for (int i = 0; i < 12; ++i) {
    const double turn = 2 * M_PI * i / 12;
    sphere.centers.emplace_back(4 * std::cos(turn), 4 * std::sin(turn), 1.5);
  }
  while (sphere.points.size() < 4000) {
    const Vector3d direction = Vector3d(normal(random), normal(random), normal(random)).normalized();
    if (direction.z() < -0.6) continue;
    FusedPoint point;
    point.position_in_world = (1 + noise * normal(random)) * direction;
    point.spread = 0.02;
    point.pixel = 0.005;
    for (std::size_t i = 0; i < sphere.centers.size(); ++i)
      if (direction.dot((sphere.centers[i] - direction).normalized()) > 0.2)
        point.seen_by.push_back(static_cast<std::uint16_t>(i));
    if (point.seen_by.size() >= 2) sphere.points.push_back(point);
  }
  return sphere;
}

TEST(SurfaceCut, FindsASphereAndLeavesOpenWhatNobodySaw) {
  for (const double noise : {0.0, 0.004}) {
    const SeenSphere sphere = MakeSeenSphere(noise, 3);
    const TriangleMesh surface = CutSurface(sphere.points, sphere.centers);
    ASSERT_GT(surface.triangles.size(), 2000u);
    std::size_t outward = 0;
    double area = 0, area_below = 0;
    for (const auto& of : surface.triangles) {
      const Eigen::Vector3f a = surface.vertices[of[0]], b = surface.vertices[of[1]],
                            c = surface.vertices[of[2]];
      outward += (b - a).cross(c - a).dot(a + b + c) > 0;
      const double size = 0.5 * (b - a).cross(c - a).norm();
      area += size;
      if ((a + b + c).norm() < 3 * 0.93) area_below += size;  // across the missing side
    }
    EXPECT_GT(static_cast<double>(outward), 0.98 * static_cast<double>(surface.triangles.size()));
    const double lowest = std::min_element(sphere.points.begin(), sphere.points.end(),
                                           [](const FusedPoint& p, const FusedPoint& q) {
                                             return p.position_in_world.z() < q.position_in_world.z();
                                           })
                              ->position_in_world.z();
    EXPECT_NEAR(area, 2 * M_PI * (1 - lowest), 0.05 * 2 * M_PI * (1 - lowest));
    EXPECT_LT(area_below, 0.02 * area);
    for (const Eigen::Vector3f& vertex : surface.vertices) EXPECT_NEAR(vertex.norm(), 1, 0.001 + 5 * noise);
  }
}

// Stray points in the air before the sphere, each seen by two cameras, are seen through by many more.
TEST(SurfaceCut, LeavesOutWhatOthersSeeThrough) {
  SeenSphere sphere = MakeSeenSphere(0, 4);
  std::mt19937 random(9);
  std::uniform_int_distribution<std::size_t> any(0, sphere.points.size() - 1);
  for (int i = 0; i < 60; ++i) {
    FusedPoint stray = sphere.points[any(random)];
    stray.position_in_world *= 1.4;
    stray.seen_by.resize(2);
    sphere.points.push_back(stray);
  }
  const TriangleMesh surface = CutSurface(sphere.points, sphere.centers);
  int strays = 0;
  for (const Eigen::Vector3f& vertex : surface.vertices) strays += vertex.norm() > 1.2f;
  EXPECT_LE(strays, 12);
}

TEST(SurfaceCut, IsTheSameWhateverTheThreads) {
  const SeenSphere sphere = MakeSeenSphere(0.004, 5);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const TriangleMesh one = CutSurface(sphere.points, sphere.centers);
  cv::setNumThreads(4);
  const TriangleMesh four = CutSurface(sphere.points, sphere.centers);
  cv::setNumThreads(threads);
  EXPECT_EQ(one.vertices, four.vertices);
  EXPECT_EQ(one.triangles, four.triangles);
}

// 1 - ZNCC of the window around a pixel and what a neighbour shows of it by way of a plane, straight from
// the definition.
float CostOfWindow(const StereoView& view, const StereoView& neighbour, float inverse_depth, int x, int y,
                   int radius, double noise) {
  const PlaneCarrier carrier = MakePlaneCarrier(view, neighbour);
  Eigen::Matrix3f h = carrier.at_infinity;
  h.col(2) += inverse_depth * carrier.per_inverse_depth;
  std::vector<double> own, other;
  for (int v = y - radius; v <= y + radius; ++v)
    for (int u = x - radius; u <= x + radius; ++u) {
      const Eigen::Vector3f at = h * Eigen::Vector3f(u + 0.5f, v + 0.5f, 1);
      const float right = std::clamp(at.x() / at.z() - 0.5f, 0.0f, neighbour.grey.cols - 1.001f),
                  down = std::clamp(at.y() / at.z() - 0.5f, 0.0f, neighbour.grey.rows - 1.001f);
      const int i = static_cast<int>(right), j = static_cast<int>(down);
      const auto pixel = [&](int dx, int dy) { return neighbour.grey.at<float>(j + dy, i + dx); };
      const float a = right - static_cast<float>(i), b = down - static_cast<float>(j);
      own.push_back(view.grey.at<float>(v, u));
      other.push_back((1 - b) * ((1 - a) * pixel(0, 0) + a * pixel(1, 0)) +
                      b * ((1 - a) * pixel(0, 1) + a * pixel(1, 1)));
    }
  const double n = static_cast<double>(own.size());
  const auto sum_of = [&](const std::vector<double>& p, const std::vector<double>& q) {
    double sum = 0, p_sum = 0, q_sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i) sum += p[i] * q[i], p_sum += p[i], q_sum += q[i];
    return sum - p_sum * q_sum / n;
  };
  const double floor = noise * noise * n;
  return static_cast<float>(1 - sum_of(own, other) /
                                    std::sqrt((sum_of(own, own) + floor) * (sum_of(other, other) + floor)));
}

// Of sizes that end within a group of pixels or a tile, and every window.
TEST(PlaneSweep, CostsAreOneMinusCorrelation) {
  const std::vector<Patch> patches{Wall(3, Mottled(0.02, 7))};
  for (const int width : {17, 117, 121})
    for (const int radius : {1, 2, 3}) {
      const Drawn view = Draw(patches, {0, 0, 0}, {0, 0, 3}, width, 41, 110),
                  neighbour = Draw(patches, {0.1, 0.02, 0}, {0, 0, 3}, width, 41, 110);
      const InverseDepthRange range{.least = 0.2, .most = 0.5, .planes = 7};
      const SweepOptions options{.window_radius_px = radius};
      PlanesOfTiles tiles(view.view.grey.size(), options.tile_px, range.planes);
      for (int column = 0; column < tiles.columns(); ++column)
        for (int row = 0; row < tiles.rows(); ++row)
          if ((column + row) % 3 > 0) tiles.Add(column, row, column % 5, column % 5 + 1);
      const CostVolume all = MatchingCosts(view.view, {&neighbour.view}, range, options),
                       some = MatchingCosts(view.view, {&neighbour.view}, range, options, &tiles);
      for (int y = radius; y < 41 - radius; ++y)
        for (int x = radius; x < width - radius; ++x)
          for (int plane = 0; plane < range.planes; ++plane) {
            const float inverse_depth = static_cast<float>(range.At(plane));
            const Eigen::Vector3d point = view.view.RayInWorld(x, y) / inverse_depth;
            const auto shown = neighbour.view.camera.ImgFromCam(neighbour.view.cam_from_world * point);
            if (!shown || !neighbour.view.camera.Contains(*shown)) continue;
            const float cost = std::min(
                1.0f, CostOfWindow(view.view, neighbour.view, inverse_depth, x, y, radius, options.noise));
            ASSERT_NEAR(all.At(x, y)[plane], CostByte(cost), 1)
                << width << " " << radius << ": " << x << " " << y;
            const bool is_compared = tiles.Has(x / options.tile_px, y / options.tile_px, plane);
            ASSERT_NEAR(some.At(x, y)[plane], is_compared ? all.At(x, y)[plane] : CostByte(1), is_compared)
                << width << " " << radius << ": " << x << " " << y;
          }
    }
}

// A wall, a board, and a post that is three pixels wide at half the size.
TEST(PlaneSweep, NearSurfacesAloneGiveTheSameDepths) {
  const std::vector<Patch> patches{{{-8, -6, 4}, {16, 0, 0}, {0, 12, 0}, Mottled(0.01, 1)},
                                   {{-1.2, -0.8, 2.4}, {0.9, 0, 0}, {0, 1.6, 0}, Mottled(0.05, 2)},
                                   {{0.4, -3, 2.2}, {0.03, 0, 0}, {0, 6, 0}, Mottled(0.02, 3)}};
  std::vector<Drawn> photographs;
  for (const auto& [x, y] : {std::pair{0., 0.}, {0.25, 0.}, {-0.25, 0.}, {0., 0.25}, {0.2, -0.2}})
    photographs.push_back(Draw(patches, {x, y, 0}, {0, 0, 3}, 480, 160, 440));
  std::vector<const StereoView*> neighbours;
  for (std::size_t i = 1; i < photographs.size(); ++i) neighbours.push_back(&photographs[i].view);
  const StereoView& view = photographs[0].view;
  const InverseDepthRange range = PixelSpacedRange(view, neighbours, 1.8, 6);

  const PlanesOfTiles compared = PlanesNearSurfaces(view, neighbours, range);
  EXPECT_LT(compared.Share(), 0.5) << "else nothing is gained";
  const CostVolume all = MatchingCosts(view, neighbours, range),
                   some = MatchingCosts(view, neighbours, range, {}, &compared);
  for (int y = 0; y < all.height(); y += 7)
    for (int x = 0; x < all.width(); x += 5)
      for (int plane = 0; plane < range.planes; ++plane) {
        const bool is_compared = compared.Has(x / compared.tile_px(), y / compared.tile_px(), plane);
        ASSERT_NEAR(some.At(x, y)[plane], is_compared ? all.At(x, y)[plane] : CostByte(1),
                    is_compared ? 1 : 0)
            << x << " " << y << " " << plane;
      }

  const DepthMap full = SweepPlanes(view, neighbours, range, {.coarse_from_px = 0}),
                 near = SweepPlanes(view, neighbours, range);
  const double step = (range.most - range.least) / (range.planes - 1);
  const auto right = [&](const DepthMap& map, double nearest, double farthest) {
    int right = 0, all = 0;
    for (int y = 5; y < map.depth.rows - 5; ++y)
      for (int x = 5; x < map.depth.cols - 5; ++x) {
        const double truth = photographs[0].depth.at<float>(y, x), found = map.depth.at<float>(y, x);
        if (truth < nearest || truth > farthest) continue;
        ++all;
        right += found > 0 && std::abs(1 / truth - 1 / found) < 1.5 * step;
      }
    return static_cast<double>(right) / all;
  };
  EXPECT_GE(right(near, 0, 10), right(full, 0, 10) - 0.002);
  // Fewer pixels than SweepOptions::liked_by bring no plane in, so that some of the post goes.
  EXPECT_GE(right(near, 0, 2.3), 0.75 * right(full, 0, 2.3)) << "the post";
  EXPECT_GT(right(full, 0, 2.3), 0.3);
}

}  // namespace
}  // namespace ulf::stereo_test
