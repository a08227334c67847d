// Two points of every curve of docs/measured/stability.md, on the first of the seeds that it reports: an easy
// one that must be right, and one beyond the breaking point that must not be wrong without a word. And the
// measuring itself, on a method whose failures are known.
#include "tests/stability/curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

namespace ulf::test {
namespace {

constexpr unsigned kSeeds = 3;

class EveryCurve : public testing::TestWithParam<std::size_t> {
 protected:
  void SetUp() override {
    // Some start a camera to answer: once for all that is asked of the curve.
    static std::map<std::string, std::optional<std::string>> known;
    const auto [why_not, is_new] = known.try_emplace(curve.name);
    if (is_new) why_not->second = curve.why_not();
    if (why_not->second) GTEST_SKIP() << *why_not->second;
  }
  // Trials with a camera take as long as the camera does: one is enough every day.
  unsigned Seeds() const { return curve.name.starts_with("camera_") ? 1 : kSeeds; }
  const Curve curve = AllCurves()[GetParam()];
};

TEST_P(EveryCurve, IsRightWhereItIsEasy) {
  for (unsigned seed = kFirstSeed; seed < kFirstSeed + Seeds(); ++seed) {
    const Trial trial = curve.trial(curve.easy, seed);
    EXPECT_EQ(trial.verdict, Verdict::kRight) << curve.name << " seed " << seed << ": " << trial.error;
  }
}

TEST_P(EveryCurve, SaysSoWhereItFails) {
  unsigned not_right = 0, wrong = 0;
  std::string seen;
  for (unsigned seed = kFirstSeed; seed < kFirstSeed + Seeds(); ++seed) {
    const Trial trial = curve.trial(curve.hard, seed);
    not_right += trial.verdict != Verdict::kRight;
    wrong += trial.verdict == Verdict::kWrong;
    seen += " " + std::to_string(trial.error);
  }
  EXPECT_LE(wrong, curve.rarely_wrong > 0 ? 1u : 0u) << curve.name << ":" << seen;
  if (curve.never_breaks.empty() && !curve.wrong_from) {
    EXPECT_GE(not_right, 1u) << curve.name << ":" << seen;
  }
}

TEST_P(EveryCurve, IsDrivenFromEasyToHard) {
  const auto& values = curve.values;
  EXPECT_GE(values.size(), 4u);
  EXPECT_TRUE(std::is_sorted(values.begin(), values.end(), std::less_equal<>()) ||
              std::is_sorted(values.begin(), values.end(), std::greater_equal<>()))
      << curve.name;
  const auto easy = std::find(values.begin(), values.end(), curve.easy),
             hard = std::find(values.begin(), values.end(), curve.hard);
  ASSERT_NE(hard, values.end()) << curve.name;
  EXPECT_LT(easy, hard) << curve.name;
}

TEST_P(EveryCurve, IsDescribed) {
  EXPECT_FALSE(curve.about.empty());
  EXPECT_EQ(curve.rarely_wrong > 0 || curve.wrong_from, !curve.why_wrong.empty()) << curve.name;
  EXPECT_LE(curve.rarely_wrong, 0.1) << curve.name << ": that is not rare";
}

INSTANTIATE_TEST_SUITE_P(Stability, EveryCurve, testing::Range<std::size_t>(0, AllCurves().size()),
                         [](const auto& info) { return AllCurves()[info.param].name; });

// Right up to 3, says so up to 5, wrong beyond.
Curve Known() {
  Curve curve;
  curve.name = "known";
  curve.values = {1, 2, 3, 4, 5, 6};
  curve.easy = 1;
  curve.hard = 6;
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
  const MeasuredCurve measured = Measure(Known(), false);
  ASSERT_EQ(measured.points.size(), 6u);
  EXPECT_EQ(measured.points[0].trials.size(), 4u);
  EXPECT_EQ(measured.BreakingPoint(), 3);
  EXPECT_FALSE(measured.NeverBroke());
  EXPECT_EQ(measured.WorstShareWrong(), 1);
  const std::string page = StabilityPage({measured}, "stability");
  EXPECT_NE(page.find("| 3 |"), std::string::npos) << page;
  EXPECT_NE(page.find("| 4 of 4, at 6 |"), std::string::npos) << page;
}

TEST(MeasuredCurve, IsMeasuredOnFreshSeedsThatItNames) {
  Curve curve = Known();
  std::set<unsigned> seeds;
  curve.trial = [&](double, unsigned seed) {
    seeds.insert(seed);
    return Trial{Verdict::kRight, 0};
  };
  const MeasuredCurve measured = Measure(curve, false);
  EXPECT_EQ(seeds, (std::set<unsigned>{101, 102, 103, 104}));
  EXPECT_NE(StabilityPage({measured}, "stability").find("| 101 to 104 |"), std::string::npos);
  EXPECT_NE(ChartOf(measured).about.find("Seeds 101 to 104"), std::string::npos);
}

TEST(MeasuredCurve, ToleratesOnlyWhatIsKnownToBeWrong) {
  Curve curve = Known();
  EXPECT_FALSE(Measure(curve, false).WrongAsKnown());
  curve.wrong_from = 6;
  EXPECT_TRUE(Measure(curve, false).WrongAsKnown());
  curve.wrong_from = 7;
  EXPECT_FALSE(Measure(curve, false).WrongAsKnown());
  curve.rarely_wrong = 1;
  EXPECT_TRUE(Measure(curve, false).WrongAsKnown());
  // Where less is harder.
  curve = Known();
  curve.values = {9, 8, 7, 6};
  curve.wrong_from = 7;
  EXPECT_FALSE(Measure(curve, false).WrongAsKnown());
  curve.wrong_from = 9;
  EXPECT_TRUE(Measure(curve, false).WrongAsKnown());
}

TEST(MeasuredCurve, UnmeasuredOnesAreListedWithReasons) {
  Curve curve = Known();
  curve.why_not = [] { return std::optional<std::string>("no network of its own"); };
  const MeasuredCurve skipped = Measure(curve, false);
  EXPECT_TRUE(skipped.points.empty());
  EXPECT_TRUE(skipped.WrongAsKnown());
  const std::string page = StabilityPage({skipped, Measure(Known(), false)}, "stability");
  EXPECT_NE(page.find("not measured: no network of its own"), std::string::npos) << page;
  EXPECT_NE(page.find("| 3 |"), std::string::npos) << "the other curve is there all the same";
}

TEST(MeasuredCurve, CarefulAnswerIsACaseOfItsOwn) {
  Curve curve = Known();
  curve.careful = "higher than need be";
  curve.trial = [](double difficulty, unsigned) {
    return Trial{difficulty <= 3 ? Verdict::kRight : Verdict::kCareful, 1};
  };
  const MeasuredCurve measured = Measure(curve, false);
  EXPECT_EQ(measured.BreakingPoint(), 3);
  EXPECT_EQ(measured.WorstShareWrong(), 0);
  EXPECT_NE(StabilityPage({measured}, "stability").find("100 % higher than need be"), std::string::npos);
}

TEST(MeasuredCurve, IsDrawnWithHarderToTheRight) {
  Curve curve = Known();
  EXPECT_FALSE(ChartOf(Measure(curve, false)).panels[0].cost.falls);
  curve.values = {6, 5, 4, 3};
  const Chart chart = ChartOf(Measure(curve, false));
  EXPECT_TRUE(chart.panels[0].cost.falls && chart.panels[1].cost.falls && chart.same_costs);
  EXPECT_NE(PictureOf(chart).script.find("set xrange [6"), std::string::npos);
}

TEST(MeasuredCurve, IsNotRightAgainAfterItBroke) {
  Curve curve = Known();
  curve.trial = [](double difficulty, unsigned seed) {
    return Trial{difficulty == 2 && seed == kFirstSeed ? Verdict::kSaidSo : Verdict::kRight, 0};
  };
  EXPECT_EQ(Measure(curve, false).BreakingPoint(), 1);
}

TEST(MeasuredCurve, DrawsErrorsOfAnswersOnly) {
  const Chart chart = ChartOf(Measure(Known(), false));
  ASSERT_EQ(chart.panels.size(), 2u);
  const auto& errors = chart.panels[1].points;
  ASSERT_EQ(errors.size(), 6u);
  EXPECT_EQ(errors[2].error.median, 3);
  EXPECT_FALSE(std::isfinite(errors[3].error.median));
  EXPECT_EQ(errors[5].error.median, 6);
}

}  // namespace
}  // namespace ulf::test
