// Two points of every curve of docs/stability.md: an easy one that must be right, and one beyond the breaking
// point that must not be wrong without a word. And the measuring itself, on a method whose failures are
// known.
#include "tests/stability/curve.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace ulf::test {
namespace {

constexpr unsigned kSeeds = 3;

class EveryCurve : public testing::TestWithParam<std::size_t> {
 protected:
  void SetUp() override {
    if (const auto why_not = curve.why_not()) GTEST_SKIP() << *why_not;
  }
  const Curve curve = AllCurves()[GetParam()];
};

TEST_P(EveryCurve, IsRightWhereItIsEasy) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const Trial trial = curve.trial(curve.easy, seed);
    EXPECT_EQ(trial.verdict, Verdict::kRight) << curve.name << " seed " << seed << ": " << trial.error;
  }
}

TEST_P(EveryCurve, SaysSoWhereItFails) {
  unsigned said = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const Trial trial = curve.trial(curve.hard, seed);
    EXPECT_NE(trial.verdict, Verdict::kWrong) << curve.name << " seed " << seed << ": " << trial.error;
    said += trial.verdict == Verdict::kSaidSo;
  }
  if (curve.breaks) {
    EXPECT_GE(2 * said, kSeeds) << curve.name;
  }
}

TEST_P(EveryCurve, IsDrivenFromEasyToHard) {
  EXPECT_NE(std::find(curve.values.begin(), curve.values.end(), curve.easy), curve.values.end());
  EXPECT_NE(std::find(curve.values.begin(), curve.values.end(), curve.hard), curve.values.end());
  EXPECT_GE(curve.values.size(), 4u);
  EXPECT_FALSE(curve.about.empty());
}

INSTANTIATE_TEST_SUITE_P(Stability, EveryCurve, testing::Range<std::size_t>(0, AllCurves().size()),
                         [](const auto& info) { return AllCurves()[info.param].name; });

// Right up to 3, silent up to 5, wrong beyond.
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
  EXPECT_NE(page.find("100 % |"), std::string::npos) << page;
}

TEST(MeasuredCurve, IsNotRightAgainAfterItBroke) {
  Curve curve = Known();
  curve.trial = [](double difficulty, unsigned seed) {
    return Trial{difficulty == 2 && seed == 1 ? Verdict::kSaidSo : Verdict::kRight, 0};
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
