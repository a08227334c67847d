// The measuring of stability curves, on a method whose failures are known.
#include "tests/measure/curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <set>
#include <string>

namespace ulf::test {
namespace {

// Right up to 3, says so up to 5, wrong beyond.
Curve Known() {
  Curve curve;
  curve.name = "known";
  curve.driven = {{"difficulty"}, {1, 2, 3, 4, 5, 6}, 1, 6};
  curve.seeds = 4;
  curve.trial = [](double difficulty, unsigned) {
    return Trial{difficulty <= 3   ? Verdict::kRight
                 : difficulty <= 5 ? Verdict::kSaidSo
                                   : Verdict::kWrong,
                 difficulty};
  };
  return curve;
}

TEST(MeasuredCurve, TellsTheBreakingPointAndWhatIsWrong) {
  const MeasuredCurve measured = Measure(Known(), {});
  ASSERT_EQ(measured.points.size(), 6u);
  EXPECT_EQ(measured.trials, 4u);
  EXPECT_EQ(measured.BreakingPoint(), 3);
  EXPECT_FALSE(measured.NeverBroke());
  EXPECT_EQ(measured.WorstShareWrong(), 1);
  const std::string page = StabilityPage({measured}, "stability");
  EXPECT_NE(page.find("| 3 |"), std::string::npos) << page;
  EXPECT_NE(page.find("| 4, at 6 |"), std::string::npos) << page;
}

TEST(MeasuredCurve, IsMeasuredOnFreshSeedsThatItNames) {
  Curve curve = Known();
  std::set<unsigned> seeds;
  curve.trial = [&](double, unsigned seed) {
    seeds.insert(seed);
    return Trial{Verdict::kRight, 0};
  };
  const MeasuredCurve measured = Measure(curve, {});
  EXPECT_EQ(seeds, (std::set<unsigned>{101, 102, 103, 104}));
  EXPECT_NE(StabilityPage({measured}, "stability").find("| 4 |"), std::string::npos);
  EXPECT_NE(ChartOf(measured).found.find("Seeds 101 to 104"), std::string::npos);
}

TEST(MeasuredCurve, ToleratesOnlyWhatIsKnownToBeWrong) {
  Curve curve = Known();
  EXPECT_FALSE(Measure(curve, {}).WrongAsKnown());
  curve.wrong_from = 6;
  EXPECT_TRUE(Measure(curve, {}).WrongAsKnown());
  curve.wrong_from = 7;
  EXPECT_FALSE(Measure(curve, {}).WrongAsKnown());
  curve.rarely_wrong = 1;
  EXPECT_TRUE(Measure(curve, {}).WrongAsKnown());
  // Where less is harder.
  curve = Known();
  curve.driven.values = {9, 8, 7, 6};
  curve.wrong_from = 7;
  EXPECT_FALSE(Measure(curve, {}).WrongAsKnown());
  curve.wrong_from = 9;
  EXPECT_TRUE(Measure(curve, {}).WrongAsKnown());
}

TEST(MeasuredCurve, UnmeasuredOnesAreListed) {
  Curve curve = Known();
  curve.why_not = [] { return std::optional<std::string>("no network of its own"); };
  EXPECT_THROW(MeasurementOf(curve).measure({}), NotHere);
  const std::string page = StabilityPage({MeasuredCurve{.curve = curve}, Measure(Known(), {})}, "stability");
  EXPECT_NE(page.find("not measured"), std::string::npos) << page;
  EXPECT_NE(page.find("| 3 |"), std::string::npos) << "the other curve is there all the same";
}

TEST(MeasuredCurve, ComesBackFromItsChart) {
  const MeasuredCurve measured = Measure(Known(), {});
  Chart chart = ChartOf(measured);
  chart.caption = "command  ·  machine  ·  date  ·  commit";
  const MeasuredCurve again = FromChart(Known(), chart);
  EXPECT_EQ(again.BreakingPoint(), 3);
  EXPECT_EQ(again.WorstShareWrong(), 1);
  EXPECT_NE(StabilityPage({again}, "stability").find("Measured: machine  ·  date  ·  commit."),
            std::string::npos);
}

TEST(MeasuredCurve, ComplainsOfMoreThanIsKnown) {
  EXPECT_FALSE(MeasurementOf(Known()).complaint(ChartOf(Measure(Known(), {}))).empty());
  Curve curve = Known();
  curve.wrong_from = 6;
  EXPECT_TRUE(MeasurementOf(curve).complaint(ChartOf(Measure(curve, {}))).empty());
}

TEST(MeasuredCurve, CarefulAnswerIsACaseOfItsOwn) {
  Curve curve = Known();
  curve.careful = "higher than need be";
  curve.trial = [](double difficulty, unsigned) {
    return Trial{difficulty <= 3 ? Verdict::kRight : Verdict::kCareful, 1};
  };
  const MeasuredCurve measured = Measure(curve, {});
  EXPECT_EQ(measured.BreakingPoint(), 3);
  EXPECT_EQ(measured.WorstShareWrong(), 0);
  EXPECT_NE(StabilityPage({measured}, "stability").find("100 % higher than need be"), std::string::npos);
}

TEST(MeasuredCurve, IsDrawnWithHarderToTheRight) {
  Curve curve = Known();
  EXPECT_FALSE(ChartOf(Measure(curve, {})).panels[0].cost.falls);
  curve.driven.values = {6, 5, 4, 3};
  const Chart chart = ChartOf(Measure(curve, {}));
  EXPECT_TRUE(chart.panels[0].cost.falls && chart.panels[1].cost.falls && chart.same_costs);
  EXPECT_NE(PictureOf(chart).script.find("set xrange [6"), std::string::npos);
}

TEST(MeasuredCurve, IsNotRightAgainAfterItBroke) {
  Curve curve = Known();
  curve.trial = [](double difficulty, unsigned seed) {
    return Trial{difficulty == 2 && seed == kFirstSeed ? Verdict::kSaidSo : Verdict::kRight, 0};
  };
  EXPECT_EQ(Measure(curve, {}).BreakingPoint(), 1);
}

TEST(MeasuredCurve, DrawsErrorsOfAnswersOnly) {
  const Chart chart = ChartOf(Measure(Known(), {}));
  ASSERT_EQ(chart.panels.size(), 2u);
  const auto& errors = chart.panels[1].points;
  ASSERT_EQ(errors.size(), 6u);
  EXPECT_EQ(errors[2].error.median, 3);
  EXPECT_FALSE(std::isfinite(errors[3].error.median));
  EXPECT_EQ(errors[5].error.median, 6);
}

}  // namespace
}  // namespace ulf::test
