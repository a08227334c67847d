// Tests: coverage/bound/guidance.
//
// What guidance promises, on coverage maps made by hand.
#include "coverage/bound/guidance.h"
#include "coverage/bound/criterion.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "coverage/bound/capture_prediction.h"
#include "tests/support/floors.h"

namespace ulf::test::guidance_test {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;
constexpr double kPeriodS = 1.0 / 15;
const Vector3d kUp = Vector3d(0.1, -0.3, 0.9).normalized();
const Subject kSubject{{0.4, -1.2, 0.7}, 0.15};
const CapFrame kFrame(Vector3d(0.9, 0.4, 0.3), kUp);

CriterionView ViewAt(double azimuth, double elevation, double distance = 1) {
  CriterionView view;
  view.fx = view.fy = 600;
  view.width = 640, view.height = 480;
  view.cx = 320, view.cy = 240;
  // About the first view, which stands in its own horizon.
  const CapFrame frame((kFrame.Direction(0, 0)), kUp);
  return view.AimedAt(kSubject.center_in_world,
                      kSubject.center_in_world + distance * frame.Direction(azimuth, elevation), kUp);
}

double Radius(double threshold_px) { return *DiscRadius({600, 1, kSubject.radius, threshold_px}); }
const double kRadius = Radius(12);
const Cap kCap = Cap::ParseDegrees("60x40");

CoverageMap MapOf(const std::vector<CriterionView>& views, const std::optional<Cap>& cap = kCap,
                  double threshold_px = 12) {
  return CoverageMap(kSubject, {.cap = cap, .up_in_world = kUp, .threshold_px = threshold_px}, views);
}

// The row through the first view and those at 1.4 disc radii below and above it, between two elevations;
// `keep` says where.
constexpr double kPitch = 1.4;
std::vector<CriterionView> Rows(
    double from, double to,
    const std::function<bool(double, double)>& keep = [](double, double) { return true; }) {
  std::vector<CriterionView> views;
  if (keep(0, 0)) views.push_back(ViewAt(0, 0));
  const int first = static_cast<int>(std::ceil(from / (kPitch * kRadius) - 1e-9));
  for (int row = first; row * kPitch * kRadius <= to + 1e-9; ++row)
    for (double azimuth = -kCap.width / 2; azimuth <= kCap.width / 2 + kRadius; azimuth += 0.9 * kRadius)
      if (const double elevation = row * kPitch * kRadius; keep(azimuth, elevation))
        views.push_back(ViewAt(azimuth, elevation));
  return views;
}
const double kBelow = -kCap.height / 2 - kRadius, kAbove = kCap.height / 2 + kRadius;

CapFrame::Angles AnglesOf(const CoverageMap& map, const Vector3d& direction) {
  return map.frame()->Of(direction);
}

// A hand that goes straight from one place to another and looks at what guidance says on the way.
struct Walk {
  const CoverageMap& map;
  Guide guide = {};
  double time_s = 0;
  std::vector<Guidance> said = {};

  const Guidance& At(double azimuth, double elevation) {
    time_s += kPeriodS;
    said.push_back(guide.Update(&map, ViewAt(azimuth, elevation), time_s));
    return said.back();
  }
  const Guidance& Go(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double speed = 12 * kDegree) {
    const int steps = std::max(1, static_cast<int>(std::lround((to - from).norm() / speed / kPeriodS)));
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2d at = from + i * (to - from) / steps;
      At(at.x(), at.y());
    }
    return said.back();
  }
};

double Between(const Vector3d& a, const Vector3d& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }
Vector3d DirectionOf(const CriterionView& view) {
  return (view.center_in_world - kSubject.center_in_world).normalized();
}

TEST(Guide, GivesTheDistanceFirstThenTheNextView) {
  CoverageMap map(kSubject, {.cap = kCap, .up_in_world = kUp, .threshold_px = 12});
  Guide guide;
  const Guidance before = guide.Update(&map, ViewAt(0, 0, 1.1), 0);
  EXPECT_FALSE(before.toward);
  EXPECT_NEAR(before.distance, 1.1, 1e-9);
  map.Add(ViewAt(0, 0, 1.1));
  const Guidance after = guide.Update(&map, ViewAt(0, 0, 1.1), kPeriodS);
  ASSERT_TRUE(after.toward);
  EXPECT_LT(map.At(*after.toward)->index, 0) << "what is painted is not asked for again";
  EXPECT_LT(Between(*after.toward, DirectionOf(ViewAt(0, 0))), 5 * after.disc_radius);
  EXPECT_NEAR(after.distance, 1.1, 1e-9);
  EXPECT_NEAR(*after.views_left / ViewsEstimate::Of(kCap, after.disc_radius).usual, 1, 0.1);
}

TEST(Guide, WithoutSubjectOrPoseItInventsNothing) {
  Guide guide;
  EXPECT_FALSE(guide.Update(nullptr, ViewAt(0, 0), 0).toward);
  EXPECT_EQ(guide.Update(nullptr, std::nullopt, 1).distance, 0);
  const CoverageMap map = MapOf({ViewAt(0, 0)});
  const Guidance seen = guide.Update(&map, ViewAt(0, 0), 2);
  const Guidance lost = guide.Update(&map, std::nullopt, 2.1);
  EXPECT_EQ(*lost.toward, *seen.toward) << "a lost camera's goal stays where it was";
}

TEST(Guide, NothingIsMissingInAFullCap) {
  const CoverageMap map = MapOf(Rows(kBelow, kAbove));
  ASSERT_GT(map.CoveredShare(), 0.999);
  Walk walk{map};
  EXPECT_FALSE(walk.Go({0, 0}, {0.1, 0.1}).toward);
  EXPECT_LT(*walk.said.back().views_left, 1);
}

// A row goes on the way it goes, beside what is painted, wherever between two and half a radius off it the
// hand is.
TEST(Guide, RowGoesOnInItsDirectionWithoutGaps) {
  const CoverageMap map = MapOf(Rows(kBelow, 0));
  constexpr double last_row = 0;
  for (const int heading : {1, -1})
    for (const double off : {1.2, 1.5, 1.9}) {
      Walk walk{map};
      const double level = last_row + off * kRadius;
      const Guidance& said = walk.Go({-heading * 28 * kDegree, level}, {-heading * 8 * kDegree, level});
      ASSERT_TRUE(said.toward);
      const auto to = AnglesOf(map, *said.toward);
      EXPECT_GT(heading * to.azimuth, -8 * kDegree + 2 * kRadius) << "ahead";
      EXPECT_NEAR((to.elevation - last_row) / kRadius, 1.55, 0.2) << off;
      ASSERT_TRUE(said.row);
      EXPECT_NEAR(said.row->now / kRadius, off, 0.1);
      EXPECT_NEAR(said.row->wanted / kRadius, 1.55, 0.2);
    }
}

TEST(Guide, AMissedStripeIsAskedForAndFollowed) {
  const double stripe = -2 * kPitch * kRadius;
  const CoverageMap map = MapOf(Rows(kBelow, kAbove, [&](double azimuth, double elevation) {
    return std::abs(elevation - stripe) > 0.1 * kRadius || std::abs(azimuth) > 20 * kDegree;
  }));
  for (const Eigen::Vector2d& start : {Eigen::Vector2d(0.3, 0.2), Eigen::Vector2d(-0.4, -0.3)}) {
    Walk walk{map};
    const Guidance& said = walk.Go(start, start + Eigen::Vector2d(0.02, 0));
    ASSERT_TRUE(said.toward);
    EXPECT_LT(map.At(*said.toward)->index, 0);
    EXPECT_NEAR(AnglesOf(map, *said.toward).elevation, stripe, 0.4 * kRadius);
  }
  Walk walk{map};
  const Guidance& along = walk.Go({-18 * kDegree, stripe}, {-5 * kDegree, stripe});
  EXPECT_GT(AnglesOf(map, *along.toward).azimuth, 0);
  EXPECT_NEAR(AnglesOf(map, *along.toward).elevation, stripe, 0.3 * kRadius);
}

TEST(Guide, HoleBehindWaitsUntilTheRowIsDone) {
  const double hole_azimuth = -15 * kDegree, row = -2 * kPitch * kRadius;
  const auto around_hole = [&](double azimuth, double elevation) {
    return std::hypot(azimuth - hole_azimuth, elevation - row) > 0.8 * kRadius;
  };
  const CoverageMap half = MapOf(Rows(kBelow, 0, around_hole));
  const Vector3d hole = half.frame()->Direction(hole_azimuth, row);
  ASSERT_LT(half.At(hole)->index, 0);
  Walk walk{half};
  const double level = 1.5 * kRadius;
  for (const Guidance* said = &walk.Go({-5 * kDegree, level}, {5 * kDegree, level}); said; said = nullptr)
    EXPECT_GT(AnglesOf(half, *said->toward).azimuth, 5 * kDegree) << "the row goes on";
  const CoverageMap rest = MapOf(Rows(kBelow, kAbove, around_hole));
  Walk after{rest};
  const Guidance& said = after.Go({20 * kDegree, 10 * kDegree}, {22 * kDegree, 10 * kDegree});
  ASSERT_TRUE(said.toward);
  EXPECT_LT(Between(*said.toward, hole), kRadius);
}

TEST(Guide, BetweenTwoHolesItDoesNotChangeItsMind) {
  const CoverageMap map = MapOf(Rows(kBelow, kAbove, [](double azimuth, double elevation) {
    return std::hypot(std::abs(azimuth) - 12 * kDegree, elevation) > kRadius;
  }));
  Walk walk{map};
  std::optional<Vector3d> first;
  for (int i = 0; i < 60; ++i) {  // the hand wavers about the middle
    const Guidance& said =
        walk.At(std::sin(0.7 * i) * 1.5 * kDegree, 10 * kDegree + std::cos(1.1 * i) * kDegree);
    ASSERT_TRUE(said.toward);
    if (!first) first = said.toward;
    ASSERT_LT(Between(*first, *said.toward), kRadius) << "frame " << i;
  }
}

TEST(Guide, GivesUpDirectionsThatStayOpen) {
  const auto hole_at = [](double azimuth0) {
    return
        [=](double azimuth, double elevation) { return std::hypot(azimuth - azimuth0, elevation) > kRadius; };
  };
  const auto one = hole_at(12 * kDegree), other = hole_at(-20 * kDegree);
  const CoverageMap two = MapOf(Rows(kBelow, kAbove, [&](double azimuth, double elevation) {
    return one(azimuth, elevation) && other(azimuth, elevation);
  }));
  Walk walk{two};
  const Vector3d first = *walk.Go({5 * kDegree, 0}, {8 * kDegree, 0}).toward;
  EXPECT_GT(AnglesOf(two, first).azimuth, 0);
  for (int i = 0; i < 15 * 15; ++i) walk.At(12 * kDegree, 0);  // nothing is recorded there, for 15 s
  const auto changed = std::find_if(walk.said.begin(), walk.said.end(), [&](const Guidance& said) {
    return said.toward && AnglesOf(two, *said.toward).azimuth < 0;
  });
  EXPECT_TRUE(changed != walk.said.end()) << "it goes on to the other hole";
  const CoverageMap last = MapOf(Rows(kBelow, kAbove, one));
  Walk again{last};
  for (int i = 0; i < 12 * 15; ++i) again.At(12 * kDegree, 0);
  EXPECT_FALSE(again.said.back().toward) << "nothing else is left: nothing is asked for";
  for (int i = 0; i < 25 * 15; ++i) again.At(12 * kDegree, 0);
  EXPECT_TRUE(std::any_of(again.said.end() - 25 * 15, again.said.end(), [](const Guidance& said) {
    return said.toward.has_value();
  })) << "later it may be tried again";
}

TEST(Guide, TheDistanceToKeepIsTheMedianOfViewsAtSeveral) {
  std::vector<CriterionView> views;
  for (int i = 0; i < 21; ++i) views.push_back(ViewAt(i * kRadius, 0, i < 14 ? 1 : 1.3));
  const CoverageMap map = MapOf(views);
  Guide guide;
  const Guidance said = guide.Update(&map, ViewAt(0, 0, 1.3), 0);
  EXPECT_NEAR(said.distance, 1, 0.011);
  EXPECT_TRUE(said.toward);
}

TEST(Guide, TellsWhatTheMovementLeavesOpen) {
  const CoverageMap map = MapOf(Rows(kBelow, 0));
  constexpr double last_row = 0;
  Walk well{map}, too_far{map};
  const double good = last_row + 1.5 * kRadius, far = last_row + 2.1 * kRadius;
  EXPECT_TRUE(well.Go({-20 * kDegree, good}, {-8 * kDegree, good}).left_open.empty());
  const Guidance& said = too_far.Go({-20 * kDegree, far}, {-8 * kDegree, far});
  ASSERT_FALSE(said.left_open.empty());
  for (const Vector3d& open : said.left_open) {
    EXPECT_LT(map.At(open)->index, 0);
    EXPECT_GT(AnglesOf(map, open).elevation, last_row);
    EXPECT_LT(AnglesOf(map, open).elevation, far);
  }
}

TEST(Guide, GoesOnAcrossTheBackAndNearThePoles) {
  std::vector<CriterionView> views;
  for (double azimuth = 0; azimuth < 360; azimuth += 2) views.push_back(ViewAt(azimuth * kDegree, 0));
  for (const double azimuth : {120.0, 150.0}) views.push_back(ViewAt(azimuth * kDegree, 80 * kDegree));
  const CoverageMap map = MapOf(views, Cap::WholeSphere());
  Walk walk{map};
  const double level = 1.55 * kRadius;
  const Guidance& said = walk.Go({165 * kDegree, level}, {176 * kDegree, level});
  ASSERT_TRUE(said.toward);
  const double ahead = std::remainder(AnglesOf(map, *said.toward).azimuth - 176 * kDegree, 2 * M_PI);
  EXPECT_GT(ahead, kRadius);
  EXPECT_LT(ahead, 6 * kRadius);
  for (const double elevation : {82.0, 88.0, -89.9}) {
    Walk pole{map};
    const Guidance& there = pole.Go({1, elevation * kDegree}, {1.2, elevation * kDegree});
    ASSERT_TRUE(there.toward) << elevation;
    EXPECT_NEAR(there.toward->norm(), 1, 1e-9);
    EXPECT_LT(Between(*there.toward, DirectionOf(ViewAt(1.2, elevation * kDegree))), 8 * kRadius)
        << elevation;
  }
}

// Who goes where they are told and records what is new: the dot moves towards `toward`.
struct Obedient {
  CoverageMap map;
  Guide guide = {};
  Vector3d dot = kFrame.Direction(0, 0);
  double time_s = 0;
  int jumps = 0;
  double way = 0;
  std::optional<Vector3d> before = {};
  Guidance said = {};

  // False when nothing more is asked for.
  bool Step(double speed = 12 * kDegree) {
    CriterionView view = ViewAt(0, 0);
    view = view.AimedAt(kSubject.center_in_world, kSubject.center_in_world + dot, kUp);
    if (!map.Covers(view)) map.Add(view);
    time_s += kPeriodS;
    said = guide.Update(&map, view, time_s);
    if (!said.toward) return false;
    if (before && Between(*before, *said.toward) > 4 * said.disc_radius) ++jumps;
    before = said.toward;
    const double step = std::min(speed * kPeriodS, Between(dot, *said.toward));
    const Vector3d axis = dot.cross(*said.toward);
    if (axis.norm() > 1e-9) dot = Eigen::AngleAxisd(step, axis.normalized()) * dot;
    way += step;
    return true;
  }
};

TEST(Guide, FollowingItCoversTheCapWithoutDetours) {
  for (const double threshold_px : {7.0, 12.0}) {
    Obedient person{MapOf({}, kCap, threshold_px)};
    const double radius = Radius(threshold_px);
    while (person.Step() && person.map.CoveredShare() < 0.98) ASSERT_LT(person.time_s, 400);
    EXPECT_GT(person.map.CoveredShare(), 0.98);
    const double least = kCap.SolidAngle() / (1.5 * std::sqrt(3.0) * radius * radius);
    EXPECT_LT(static_cast<double>(person.map.views().size()), 1.75 * least) << threshold_px;
    const double rows = kCap.height / (1.55 * radius);
    EXPECT_LT(person.way, 1.5 * rows * kCap.width) << threshold_px;
    EXPECT_LT(person.jumps, 5 * rows) << threshold_px;
    // Nor is anything asked for that cannot be had.
    while (person.Step()) ASSERT_LT(person.time_s, 500);
    EXPECT_GT(person.map.CoveredShare(), 0.995);
  }
}

TEST(Guide, ExtendsCompactlyWithoutACap) {
  Obedient person{MapOf({}, std::nullopt)};
  while (person.map.views().size() < 150) {
    ASSERT_TRUE(person.Step());
    ASSERT_LT(person.time_s, 300);
  }
  double left = 0, right = 0, bottom = 0, top = 0;
  for (const CriterionView& view : person.map.views()) {
    const auto at = AnglesOf(person.map, DirectionOf(view));
    left = std::min(left, at.azimuth), right = std::max(right, at.azimuth);
    bottom = std::min(bottom, at.elevation), top = std::max(top, at.elevation);
  }
  EXPECT_LT((right - left) / (top - bottom), 3);
  EXPECT_GT((right - left) / (top - bottom), 1.0 / 3);
  int covered = 0, all = 0;
  for (double azimuth = left; azimuth <= right; azimuth += 0.5 * kRadius)
    for (double elevation = bottom; elevation <= top; elevation += 0.5 * kRadius, ++all)
      covered += person.map.At(person.map.frame()->Direction(azimuth, elevation))->index >= 0;
  EXPECT_GT(covered, 0.6 * all) << "no frayed edges";
}

TEST(Guide, SaysTheSameTwice) {
  Obedient one{MapOf({})}, two{MapOf({})};
  for (int i = 0; i < 300; ++i) {
    one.Step(), two.Step();
    ASSERT_EQ(one.dot, two.dot) << i;
  }
}

// Whoever follows it: the expected end moves by at most a quarter of the whole time, and a rest adds no
// more than itself.
TEST(Guide, TheExpectedEndIsSteady) {
  for (const double rest_s : {0.0, 60.0}) {
    Obedient person{.map = MapOf({}), .guide = Guide(0.98)};
    std::vector<double> ends_s;
    const auto look = [&](const Guidance& said) {
      if (said.seconds_left) ends_s.push_back(person.time_s + *said.seconds_left);
    };
    while (person.map.CoveredShare() < 0.5 && person.Step()) look(person.said);
    const CriterionView here = person.map.views().back();
    for (double rested_s = 0; rested_s < rest_s; rested_s += kPeriodS)
      look(person.guide.Update(&person.map, here, person.time_s += kPeriodS));
    while (person.map.CoveredShare() < 0.98 && person.Step()) look(person.said);
    ASSERT_GT(ends_s.size(), 300u);
    const auto [first, last] = std::ranges::minmax(ends_s);
    EXPECT_LT(last - first, 0.25 * (person.time_s - rest_s) + rest_s) << rest_s;
    EXPECT_NEAR(ends_s.back(), person.time_s, 1);
  }
}

TEST(Guide, ExpectsTheTimeThatItThenTakes) {
  Obedient person{MapOf({})};
  while (person.map.CoveredShare() < 0.3 && person.Step()) continue;
  const Guidance said = person.guide.Update(&person.map, std::nullopt, person.time_s + kPeriodS);
  ASSERT_TRUE(said.seconds_left && said.views_left);
  const double then_s = person.time_s;
  const std::size_t then = person.map.views().size();
  while (person.map.CoveredShare() < 0.99 && person.Step()) ASSERT_LT(person.time_s, 400);
  EXPECT_NEAR(*said.seconds_left / (person.time_s - then_s), 1, 0.35);
  EXPECT_NEAR(*said.views_left / static_cast<double>(person.map.views().size() - then), 1, 0.25);
}

}  // namespace
}  // namespace ulf::test::guidance_test
