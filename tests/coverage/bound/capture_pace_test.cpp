// Tests: coverage/bound/capture_pace.
//
// A scripted capture: a hand that paints views at a pace, rests, wanders.
#include "coverage/bound/capture_pace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace ulf::test::capture_pace_test {
namespace {

using coverage::CapturePace;

constexpr double kPeriod_s = 1.0 / 15, kRadius = 0.05, kViewSr = 0.008, kCapSr = 1.2;

struct Hand {
  CapturePace pace = {};
  double time_s = 0, azimuth = 0, covered_sr = 0;
  std::size_t views = 0;
  double next_view_s = 0;

  // Moves by so many disc radii a second, and paints a view each `every_s`, or none.
  std::optional<double> Go(double seconds, double radii_per_s, double every_s) {
    if (!(next_view_s - time_s <= every_s)) next_view_s = time_s + every_s;
    if (std::isinf(every_s)) next_view_s = every_s;
    for (const double until_s = time_s + seconds; time_s < until_s;) {
      time_s += kPeriod_s;
      azimuth += radii_per_s * kRadius * kPeriod_s;
      if (time_s >= next_view_s) {
        next_view_s += every_s;
        ++views;
        covered_sr += kViewSr;
      }
      pace.Update(time_s, covered_sr, views, Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0),
                  kRadius);
    }
    return Left();
  }
  std::optional<double> Left() const { return pace.SecondsFor(kCapSr - covered_sr, kViewSr); }
};

constexpr double kNever = std::numeric_limits<double>::infinity();

// Quick and slow hands: while the pace is the same the expected end moves by at most 3 % of the whole time.
TEST(CapturePace, EndIsConstantAtASteadyPace) {
  for (const double every_s : {0.2, 0.7, 2.5}) {
    Hand hand;
    const double whole_s = every_s * kCapSr / kViewSr;
    hand.Go(std::max(10.0, 6 * every_s), 1.4 / every_s, every_s);
    while (hand.covered_sr < 0.95 * kCapSr) {
      const auto left_s = hand.Go(2 * every_s, 1.4 / every_s, every_s);
      ASSERT_TRUE(left_s) << every_s;
      EXPECT_NEAR(hand.time_s + *left_s, whole_s, 0.03 * whole_s) << every_s << ", after " << hand.time_s;
    }
  }
}

TEST(CapturePace, DoesNotRunAwayWhereTheHandRests) {
  Hand hand;
  const auto before_s = hand.Go(30, 1.4, 1);
  ASSERT_TRUE(before_s);
  for (int i = 0; i < 60; ++i) {
    const auto resting_s = hand.Go(5, 0.02, kNever);
    ASSERT_TRUE(resting_s) << "after " << 5 * i << " s";
    EXPECT_NEAR(*resting_s, *before_s, 0.02 * *before_s);
  }
  const auto after_s = hand.Go(10, 1.4, 1);
  ASSERT_TRUE(after_s);
  EXPECT_NEAR(*after_s, *before_s - 10, 0.1 * *before_s) << "and goes on as before";
}

TEST(CapturePace, IsUnknownAtFirstAndWithoutProgress) {
  Hand hand;
  EXPECT_FALSE(hand.Go(5, 1.4, 1)) << "too early";
  EXPECT_TRUE(hand.Go(25, 1.4, 1));
  EXPECT_FALSE(hand.Go(25, 1.4, kNever)) << "it goes about over what is painted";
  EXPECT_TRUE(hand.Go(10, 1.4, 1));
}

// A closed loop opens and covers areas.
TEST(CapturePace, CorrectionsAreNotCountedAsWork) {
  Hand hand;
  const auto before_s = hand.Go(30, 1.4, 1);
  ASSERT_TRUE(before_s);
  hand.covered_sr -= 5 * kViewSr;
  hand.Go(kPeriod_s, 0, kNever);
  EXPECT_NEAR(*hand.Left(), *before_s + 5, 0.02 * *before_s) << "what was opened takes its time again";
  hand.covered_sr += 5 * kViewSr;
  hand.Go(kPeriod_s, 0, kNever);
  EXPECT_NEAR(*hand.Left(), *before_s, 0.02 * *before_s);
}

}  // namespace
}  // namespace ulf::test::capture_pace_test
