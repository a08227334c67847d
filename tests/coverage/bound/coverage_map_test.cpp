// Tests: coverage/bound/coverage_map, coverage/bound/capture_prediction,
// coverage/bound/gap_words.
#include "coverage/bound/coverage_map.h"

#include <gmock/gmock.h>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/base/error.h"
#include "coverage/bound/capture_prediction.h"
#include "coverage/bound/criterion.h"
#include "coverage/bound/gap_words.h"
#include "tests/support/floors.h"

namespace ulf::test::coverage_map_test {
namespace {

using Eigen::Vector3d;

double Radians(double degrees) { return degrees * M_PI / 180; }

const Vector3d kUp = Vector3d::UnitZ();
// Nothing at the origin, nothing along an axis: what holds must hold anywhere.
const Subject kSubject{{0.4, -1.2, 0.7}, 0.3};

CriterionView Camera() {
  CriterionView view;
  view.fx = view.fy = 600;
  view.width = 640, view.height = 480;
  view.cx = 320, view.cy = 240;
  return view;
}

// At azimuth and elevation about a first view that itself stands 25 degrees above the horizon.
CriterionView ViewAt(double azimuth_deg, double elevation_deg, double distance) {
  static const CapFrame frame(Vector3d(0.9, 0.1, std::tan(Radians(25))), kUp);
  const Vector3d direction = frame.Direction(Radians(azimuth_deg), Radians(elevation_deg));
  return Camera().AimedAt(kSubject.center_in_world, kSubject.center_in_world + distance * direction, kUp);
}

TEST(Cap, HasTheSolidAngleOfItsDefinition) {
  EXPECT_NEAR(Cap::ParseDegrees("60x40").SolidAngle(), 0.716, 5e-4);
  EXPECT_NEAR(Cap::WholeSphere().SolidAngle(), 4 * M_PI, 1e-12);
}

TEST(Cap, RejectsWhatIsNoCap) {
  for (const char* text :
       {"", "60", "60x", "x40", "60x40x2", "0x40", "-60x40", "400x40", "60x190", "60 by 40"})
    EXPECT_THROW(Cap::ParseDegrees(text), Refusal) << text;
}

TEST(CapGoal, IsACapAndPerhapsAShare) {
  EXPECT_FALSE(CapGoal::Parse("60x40").share);
  EXPECT_DOUBLE_EQ(*CapGoal::Parse("60x40:95%").share, 0.95);
  EXPECT_DOUBLE_EQ(*CapGoal::Parse("60x40:0.95").share, 0.95);
  EXPECT_NEAR(CapGoal::Parse("60x40:0.95").cap.SolidAngle(), 0.716, 5e-4);
  for (const char* text : {"60x40:", "60x40:95", "60x40:0", "60x40:-1%", "60x40:some", "60:95%"})
    EXPECT_THROW(CapGoal::Parse(text), Refusal) << text;
}

// At the limit the grid is a third of what one view covers, as it must be; finer discs get a coarser one.
TEST(CoverageMap, SaysHowFineADiscItTellsApart) {
  const double finest = CoverageMap::FinestDiscRadius(Cap::WholeSphere());
  for (const double threshold_px : {2.005, 2.05, 2.5}) {
    CoverageMap map(kSubject, {.up_in_world = kUp, .threshold_px = threshold_px});
    map.Add(ViewAt(0, 0, 2));
    const double disc =
        *DiscRadius({.focal_px = 600, .distance = 2, .radius = 0.3, .threshold_px = threshold_px});
    EXPECT_EQ(map.spacing() <= disc / 3, disc >= finest) << threshold_px << " " << disc << " " << finest;
  }
}

TEST(CapturePrediction, NamesTheRangeOfDistances) {
  CapturePrediction prediction{
      .distance = 0.5, .disc_radius = 0.1, .nearest = 0.34, .farthest = {}, .views = {}};
  EXPECT_THAT(InWords(prediction, 12, false, FrameSource::kCamera),
              ::testing::HasSubstr("; keep at least 0.68 of the first distance; farther is fine"));
  EXPECT_THAT(InWords(prediction, 12, true, FrameSource::kCamera),
              ::testing::HasSubstr("; stay at least 0.34 m from the subject's centre"));
  prediction.farthest = 1.2;
  EXPECT_THAT(InWords(prediction, 12, true, FrameSource::kCamera),
              ::testing::HasSubstr("stay 0.34 to 1.20 m from the subject's"));
  prediction.views = ViewsEstimate{7, 5, 12};
  EXPECT_THAT(
      InWords(prediction, 12, true, FrameSource::kCamera),
      ::testing::HasSubstr("about 7 views (5 to 12) at 12 px within the cap, more if you go beyond it"));
  EXPECT_EQ(InWords(ViewsEstimate{1, 1, 2}), "about 1 view (1 to 2)");
}

TEST(CapturePrediction, SaysWhatIsFinerThanTheMap) {
  const double finest = CoverageMap::FinestDiscRadius(Cap::WholeSphere());
  CapturePrediction prediction{.disc_radius = 1.01 * finest, .nearest = {}, .farthest = {}, .views = {}};
  EXPECT_FALSE(ThresholdWarning(prediction, {}, FrameSource::kCamera));
  prediction.disc_radius = 0.99 * finest;
  ASSERT_TRUE(ThresholdWarning(prediction, {}, FrameSource::kCamera));
  EXPECT_THAT(*ThresholdWarning(prediction, {}, FrameSource::kCamera),
              testing::HasSubstr("small gaps will not be seen"));
  EXPECT_FALSE(ThresholdWarning(prediction, Cap::ParseDegrees("60x40"), FrameSource::kCamera))
      << "a smaller cap has a finer map";
}

TEST(CapFrame, CentresTheFirstDirectionAndRoundTrips) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    const Vector3d first = Vector3d(normal(random), normal(random), normal(random)).normalized();
    const CapFrame frame(first, kUp);
    EXPECT_NEAR((frame.Direction(0, 0) - first).norm(), 0, 1e-12);
    const double azimuth = std::uniform_real_distribution<double>(-3.1, 3.1)(random);
    const double elevation = std::uniform_real_distribution<double>(-1.5, 1.5)(random);
    const CapFrame::Angles angles = frame.Of(frame.Direction(azimuth, elevation));
    EXPECT_NEAR(angles.azimuth, azimuth, 1e-9);
    EXPECT_NEAR(angles.elevation, elevation, 1e-9);
  }
}

TEST(CapFrame, RightAndUpAreThoseOfWhoLooksAtTheSubject) {
  const CriterionView first = ViewAt(0, 0, 2);
  const CapFrame frame(first.center_in_world - kSubject.center_in_world, kUp);
  const Vector3d right = first.cam_from_world.row(0), down = first.cam_from_world.row(1);
  EXPECT_GT(frame.Direction(0.1, 0).dot(right), 0);
  EXPECT_LT(frame.Direction(0, 0.1).dot(down), 0);
}

TEST(CapFrame, HandlesLookingAlongUp) {
  const CapFrame frame(kUp, kUp);
  EXPECT_NEAR(frame.Direction(0.3, 0.2).norm(), 1, 1e-12);
}

TEST(CoverageMap, OneViewPaintsItsDisc) {
  for (const double threshold_px : {7.0, 12.0})
    for (const bool whole_sphere : {false, true}) {
      CoverageMapOptions options{.up_in_world = kUp, .threshold_px = threshold_px};
      if (!whole_sphere) options.cap = Cap::ParseDegrees("20x10");
      CoverageMap map(kSubject, options);
      map.Add(ViewAt(0, 0, 1.5));
      const double radius = *DiscRadius({600, 1.5, kSubject.radius, threshold_px});
      const double disc_sr = 2 * M_PI * (1 - std::cos(radius));
      EXPECT_NEAR(map.CoveredShare() * map.extent().SolidAngle() / disc_sr, 1, 0.1)
          << threshold_px << (whole_sphere ? " sphere" : " cap");
      EXPECT_LT(map.spacing(), radius / 3);
    }
}

TEST(CoverageMap, PaintsAcrossTheBackAndOverThePoles) {
  CoverageMap map(kSubject, {.up_in_world = kUp, .threshold_px = 40});
  map.Add(ViewAt(0, 0, 1.5));
  const double one = map.CoveredShare();
  for (const auto& [azimuth_deg, elevation_deg] : {std::pair{179.9, 3.0}, {-90.0, 89.5}, {45.0, -89.9}}) {
    const double before = map.CoveredShare();
    map.Add(ViewAt(azimuth_deg, elevation_deg, 1.5));
    EXPECT_NEAR((map.CoveredShare() - before) / one, 1, 0.1) << azimuth_deg << ", " << elevation_deg;
  }
}

TEST(CoverageMap, SaysWhichViewPaintsADirection) {
  CoverageMap map(kSubject, {.cap = Cap::ParseDegrees("40x30"), .up_in_world = kUp});
  map.Add(ViewAt(0, 0, 1.5));
  map.Add(ViewAt(8, 2, 1.5));
  const auto direction = [](const CriterionView& view) {
    return Vector3d((view.center_in_world - kSubject.center_in_world).normalized());
  };
  EXPECT_EQ(map.At(direction(ViewAt(0, 0, 1)))->index, 0);
  EXPECT_EQ(map.At(direction(ViewAt(8, 2, 1)))->index, 1);
  EXPECT_EQ(map.At(direction(ViewAt(-12, 5, 1)))->index, -1);
  EXPECT_FALSE(map.At(direction(ViewAt(30, 0, 1))));
}

std::vector<CriterionView> RandomViews(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> azimuth(-35, 35), elevation(-25, 25), distance(1.42, 1.58);
  std::vector<CriterionView> views{ViewAt(0, 0, 1.5)};
  while (static_cast<int>(views.size()) < count)
    views.push_back(ViewAt(azimuth(random), elevation(random), distance(random)));
  return views;
}

TEST(CoverageMap, PaintingViewByViewIsPaintingAllAtOnce) {
  const CoverageMapOptions options{.cap = Cap::ParseDegrees("60x40"), .up_in_world = kUp, .threshold_px = 12};
  const std::vector<CriterionView> views = RandomViews(300, 5);
  CoverageMap by_view(kSubject, options);
  const CoverageMap at_once(kSubject, options, views);
  for (const CriterionView& view : views) by_view.Add(view);
  // The reference distance may lag by a hundredth.
  EXPECT_NEAR(by_view.reference_distance() / at_once.reference_distance(), 1, 0.0101);
  EXPECT_NEAR(by_view.CoveredShare(), at_once.CoveredShare(), 0.01);
}

// The definition: directions drawn evenly over the cap, each judged against every view.
TEST(CoverageMap, TheCoveredShareFollowsItsDefinition) {
  const Cap cap = Cap::ParseDegrees("60x40");
  for (const double threshold_px : {7.0, 12.0})
    for (const int count : {40, 400}) {
      const std::vector<CriterionView> views = RandomViews(count, 6);
      const CoverageMap map(kSubject, {.cap = cap, .up_in_world = kUp, .threshold_px = threshold_px}, views);
      // None covers what is twice as far from it as its disc reaches.
      const double least_cosine = std::cos(
          2 * *DiscRadius({.focal_px = 600, .distance = 1.5, .radius = 0.3, .threshold_px = threshold_px}));
      const auto direction = [](const CriterionView& view) {
        return Vector3d((view.center_in_world - kSubject.center_in_world).normalized());
      };
      std::vector<Vector3d> directions;
      for (const CriterionView& view : views) directions.push_back(direction(view));
      std::mt19937 random(3);
      std::uniform_real_distribution<double> azimuth_deg(-30, 30),
          sine(-std::sin(Radians(20)), std::sin(Radians(20)));
      int covered = 0;
      constexpr int kSamples = 10'000;
      for (int i = 0; i < kSamples; ++i) {
        const CriterionView candidate =
            ViewAt(azimuth_deg(random), std::asin(sine(random)) * 180 / M_PI, map.reference_distance());
        const Vector3d to_candidate = direction(candidate);
        bool is_covered = false;
        for (std::size_t k = 0; k < views.size() && !is_covered; ++k)
          is_covered = directions[k].dot(to_candidate) > least_cosine &&
                       BoundPx(views[k], candidate, kSubject, 1.01 * threshold_px) <= threshold_px;
        covered += is_covered;
      }
      const double share = covered / double{kSamples};
      const double three_sigma = 3 * std::sqrt(share * (1 - share) / kSamples);
      EXPECT_GT(share, 0.005);
      EXPECT_NEAR(map.CoveredShare(), share, 0.002 + three_sigma)
          << threshold_px << ", " << count << " views";
    }
}

// Holes and what is painted make up the cap, also across the back and at the poles.
TEST(CoverageMap, HolesAreWhatIsOpen) {
  for (const char* cap : {"60x40", "360x180"}) {
    const CoverageMap map(kSubject, {.cap = Cap::ParseDegrees(cap), .up_in_world = kUp, .threshold_px = 12},
                          RandomViews(120, 5));
    double open_sr = 0;
    for (const CoverageHole& hole : map.Holes()) {
      open_sr += hole.solid_angle_sr;
      EXPECT_EQ(map.At(hole.direction)->index, -1);
    }
    EXPECT_NEAR(open_sr / map.extent().SolidAngle(), 1 - map.CoveredShare(), 1e-9) << cap;
  }
  CoverageMap behind(kSubject, {.up_in_world = kUp, .threshold_px = 12});
  behind.Add(ViewAt(0, 0, 1.5));
  EXPECT_EQ(behind.Holes().size(), 1u) << "all round the one disc";
}

TEST(CoverageMap, NothingRecordedNothingCovered) {
  const Cap cap = Cap::ParseDegrees("60x40");
  const CoverageMap map(kSubject, {.cap = cap});
  EXPECT_EQ(map.CoveredShare(), 0);
  EXPECT_FALSE(map.At(Vector3d::UnitX()));
  EXPECT_FALSE(map.Covers(ViewAt(0, 0, 1.5)));
}

TEST(SubjectViews, BestIsTheSmallestBoundOfAll) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> azimuth(-40, 40), elevation(-30, 30), distance(1.2, 1.9),
      turn(-8, 8);
  SubjectViews recorded(kSubject);
  for (const CriterionView& view : RandomViews(200, 10)) recorded.Add(view);
  for (int i = 0; i < 300; ++i) {
    CriterionView candidate = ViewAt(azimuth(random), elevation(random), distance(random));
    candidate.cam_from_world =
        Eigen::AngleAxisd(Radians(turn(random)), Vector3d::UnitY()) * candidate.cam_from_world;
    double smallest = std::numeric_limits<double>::infinity();
    for (const CriterionView& view : recorded.views())
      smallest = std::min(smallest, BoundPx(view, candidate, kSubject));
    const CoveringView best = recorded.Best(candidate);
    ASSERT_EQ(best.bound_px, smallest) << i;
    for (const double threshold_px : {7.0, 12.0})
      ASSERT_EQ(recorded.Covers(candidate, threshold_px), smallest <= threshold_px) << i;
  }
}

// Section 5 of the derivation counts rows as far apart as they may be. A hand that sweeps closer ones, here
// 0.7 disc radii apart, and records what is not covered needs more, but no more than a third or so.
TEST(CoverageMap, CloseRowsNeedMoreViewsThanEstimated) {
  const Subject subject{Vector3d::Zero(), 0.15};
  std::mt19937 random(4);
  std::normal_distribution<double> tremor(0, 0.15);
  CoverageMap map(subject, {.cap = Cap::ParseDegrees("60x40"), .up_in_world = kUp, .threshold_px = 12});
  const CapFrame frame(Vector3d::UnitX(), kUp);
  const auto look_from = [&](double azimuth_deg, double elevation_deg) {
    const CriterionView view = Camera().AimedAt(
        subject.center_in_world, frame.Direction(Radians(azimuth_deg), Radians(elevation_deg)), kUp);
    if (!map.Covers(view)) map.Add(view);
  };
  look_from(0, 0);
  double side = 1;
  for (double elevation_deg = -21; elevation_deg <= 21; elevation_deg += 2.2, side = -side)
    for (double azimuth_deg = -31; azimuth_deg <= 31; azimuth_deg += 0.25)
      look_from(side * azimuth_deg + tremor(random),
                elevation_deg + 0.4 * std::sin(azimuth_deg) + tremor(random));
  // The hand goes a little past the cap on every side.
  const double estimate =
      ViewsEstimate::Of(Cap::ParseDegrees("62x42"), *DiscRadius({600, 1, 0.15, 12})).usual;
  EXPECT_GT(map.CoveredShare(), 0.95);
  const double ratio = static_cast<double>(map.views().size()) / estimate;
  EXPECT_GT(ratio, 1) << "estimate " << estimate;
  EXPECT_LT(ratio, 1.4) << "estimate " << estimate;
}

TEST(GapWords, SayHowManyHowMuchAndWhereTheLargestIs) {
  const Cap cap = Cap::ParseDegrees("60x40");  // 2,350 square degrees
  const CapGap large{616.8, 7, 3}, small{12, -20, 0.2}, other{30, 2, -15};
  EXPECT_EQ(InWords({}, cap), "");
  EXPECT_EQ(InWords({large}, cap), "one large gap: right half, 7° right and 3° up of the first view");
  EXPECT_EQ(InWords({large, small}, cap),
            "one large gap: right half, 7° right and 3° up of the first view; and 1 small one");
  EXPECT_EQ(InWords({small}, cap), "one small gap: left half, 20° left of the first view");
  EXPECT_EQ(
      InWords({other, small}, cap),
      "2 gaps, 1.8 % of the cap in all; the largest: lower half, 2° right and 15° down of the first view");
  EXPECT_EQ(InWords({{5, 0.3, -0.2}}, cap), "one small gap: in the middle, at the first view");
  EXPECT_EQ(InWords({{1800, -1, -4}}, cap), "one large gap: most of the cap");
  EXPECT_EQ(InWords({{2349, -1, -4}}, cap), "one large gap: the whole cap");
  EXPECT_EQ(PlaceInWords(small, " degrees"), "20 degrees left of the first view");
}

}  // namespace
}  // namespace ulf::test::coverage_map_test
