// Two points of every curve, on the first of the seeds that are reported: an easy one that must be
// right, and one beyond the breaking point that must not be wrong without a word. And all of what must
// not break anywhere.
#include "tests/measure/curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

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
    const Trial trial = curve.trial(curve.driven.easy, seed);
    EXPECT_EQ(trial.verdict, Verdict::kRight) << curve.name << " seed " << seed << ": " << trial.error;
  }
}

TEST_P(EveryCurve, SaysSoWhereItFails) {
  unsigned not_right = 0, wrong = 0;
  std::string seen;
  for (unsigned seed = kFirstSeed; seed < kFirstSeed + Seeds(); ++seed) {
    const Trial trial = curve.trial(curve.driven.hard, seed);
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
  const auto& values = curve.driven.values;
  EXPECT_GE(values.size(), 4u);
  EXPECT_TRUE(std::is_sorted(values.begin(), values.end(), std::less_equal<>()) ||
              std::is_sorted(values.begin(), values.end(), std::greater_equal<>()))
      << curve.name;
  const auto easy = std::find(values.begin(), values.end(), curve.driven.easy),
             hard = std::find(values.begin(), values.end(), curve.driven.hard);
  ASSERT_NE(hard, values.end()) << curve.name;
  EXPECT_LT(easy, hard) << curve.name;
}

TEST_P(EveryCurve, IsDescribed) {
  EXPECT_FALSE(curve.about.empty());
  EXPECT_EQ(curve.rarely_wrong > 0 || curve.wrong_from, !curve.why_wrong.empty()) << curve.name;
  EXPECT_LE(curve.rarely_wrong, 0.1) << curve.name << ": that is not rare";
}

std::string NameOf(const testing::TestParamInfo<std::size_t>& info) { return AllCurves()[info.param].name; }

INSTANTIATE_TEST_SUITE_P(Stability, EveryCurve, testing::Range<std::size_t>(0, AllCurves().size()), NameOf);

// As many seeds and difficulties as a curve of the page has.
class NeverBreaks : public EveryCurve {};

TEST_P(NeverBreaks, IsRightHoweverHard) {
  const MeasuredCurve measured = Measure(curve, {});
  EXPECT_TRUE(measured.NeverBroke()) << "up to " << measured.BreakingPoint().value_or(0) << " only, though "
                                     << curve.never_breaks;
  EXPECT_TRUE(measured.WrongAsKnown()) << measured.WorstShareWrong();
}

std::vector<std::size_t> ThoseThatNeverBreak() {
  const std::vector<Curve> all = AllCurves();
  std::vector<std::size_t> those;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!all[i].never_breaks.empty()) those.push_back(i);
  return those;
}

INSTANTIATE_TEST_SUITE_P(Stability, NeverBreaks, testing::ValuesIn(ThoseThatNeverBreak()), NameOf);

}  // namespace
}  // namespace ulf::test
