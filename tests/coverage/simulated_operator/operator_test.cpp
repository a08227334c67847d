// Tests: coverage/simulated_operator/simulated_operator.
//
// Simulated people against the promise: a novice covers the whole cap without training. Without pictures; the
// same with pictures and the tracker is in operator_capture_test.cpp.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "core/base/error.h"
#include "coverage/bound/capture_prediction.h"
#include "tests/support/floors.h"
#include "tests/support/imagined_capture.h"

namespace ulf::test::operator_test {
namespace {

#ifdef ULF_ALL_SEEDS
constexpr std::uint64_t kSeeds = 20;
#else
constexpr std::uint64_t kSeeds = 1;
#endif
constexpr std::uint64_t kFirstSeed = 101;  // guidance was made with 1 to 5

TEST(SimulatedOperator, CoversTheCapGuidedAndAsANovice) {
  std::vector<std::pair<double, double>> subjects{{0.2, 7.0}, {0.28, 12.0}};  // size, threshold in px
  if (kSeeds > 2) subjects.insert(subjects.end(), {{0.28, 7.0}, {0.2, 12.0}});
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kSeeds; ++seed)
    for (const bool novice : {false, true})
      for (const auto& [size, threshold_px] : subjects) {
        const ImaginedResult result = RunImagined(
            {.person = {.novice = novice, .seed = seed}, .threshold_px = threshold_px, .subject_size = size});
        const std::string who =
            fmt::format("{} {} at {} px", novice ? "novice" : "guided", seed, threshold_px);
        EXPECT_GE(result.covered, 0.95) << who << ", subject " << size;
        EXPECT_LT(result.seconds, 420) << who << ", subject " << size;
        if (novice) {
          EXPECT_GT(result.lost_share, 0.005) << who << " loses the subject now and then";
        }
      }
}

TEST(SimulatedOperator, GuidanceSavesTime) {
  double with_s = 0, without_s = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kSeeds + 2; ++seed) {
    with_s += RunImagined({.person = {.seed = seed}}).seconds;
    without_s += RunImagined({.person = {.follows_guidance = false, .seed = seed}}).seconds;
  }
  EXPECT_LT(with_s, 0.9 * without_s);
}

// Over caps, thresholds, sizes and people; the estimate knows nothing of people.
TEST(ViewsEstimate, HoldsForWhatPeopleTake) {
  struct Case {
    const char* cap;
    double threshold_px, size, until_share;
  };
  std::vector<Case> cases{{"60x40", 12, 0.28, 0.95},
                          {"30x20", 12, 0.28, 0.98},
                          {"30x20", 20, 0.2, 0.95},
                          {"30x20", 7, 0.2, 0.98}};
  if (kSeeds > 2)
    cases.insert(cases.end(), {{"60x40", 12, 0.2, 0.95},
                               {"90x60", 20, 0.28, 0.9},
                               {"60x40", 7, 0.28, 0.95},
                               {"90x60", 12, 0.28, 0.95}});
  for (const Case& c : cases)
    for (const bool novice : {false, true})
      for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + (kSeeds + 1) / 2; ++seed) {
        const ImaginedResult result = RunImagined({.person = {.novice = novice, .seed = seed},
                                                   .threshold_px = c.threshold_px,
                                                   .cap = Cap::ParseDegrees(c.cap),
                                                   .until_share = c.until_share,
                                                   .subject_size = c.size});
        const ViewsEstimate views =
            ViewsEstimate::Of(Cap::ParseDegrees(c.cap), result.disc_radius, c.until_share);
        const std::string what =
            fmt::format("{}, {} px, {}, {} %, {}:{}, {}", c.cap, c.threshold_px, c.size, 100 * c.until_share,
                        novice ? "novice" : "guided", seed, InWords(views));
        EXPECT_GE(static_cast<double>(result.views), views.fewest) << what;
        EXPECT_LE(static_cast<double>(result.views), views.most) << what;
        EXPECT_LT(views.most / views.fewest, 2.5) << what;
        const TimeEstimate time = TimeEstimate::Of(views, result.disc_radius);
        // A novice's way is chaotic: another rounding of a sum changes the time of the same seed by seconds.
        constexpr double kRounding = 1.1;
        EXPECT_GE(kRounding * result.seconds, time.least_s) << what << ", " << InWords(time);
        EXPECT_LE(result.seconds, kRounding * time.most_s) << what << ", " << InWords(time);
        EXPECT_LT(time.most_s / time.least_s, 4) << what;
      }
}

TEST(SimulatedOperator, SameSeedGivesTheSameCapture) {
  const ImaginedCapture capture{.person = {.novice = true, .seed = 3}, .threshold_px = 12, .max_seconds = 30};
  const ImaginedResult one = RunImagined(capture), two = RunImagined(capture);
  ASSERT_EQ(one.views, two.views);
  for (std::size_t i = 0; i < one.views; ++i)
    ASSERT_EQ(one.recorded[i].center_in_world, two.recorded[i].center_in_world) << i;
}

TEST(OperatorOptions, AreParsed) {
  EXPECT_TRUE(OperatorOptions::Parse("guided").follows_guidance);
  EXPECT_FALSE(OperatorOptions::Parse("unguided:9").follows_guidance);
  EXPECT_EQ(OperatorOptions::Parse("unguided:9").seed, 9u);
  EXPECT_TRUE(OperatorOptions::Parse("novice").novice);
  EXPECT_FALSE(OperatorOptions::Parse("unguided-novice:1").follows_guidance);
  for (const char* text : {"", "expert", "novice:", "novice:x", "novice:1x", "guided:-1"})
    EXPECT_THROW(OperatorOptions::Parse(text), Refusal) << text;
}

}  // namespace
}  // namespace ulf::test::operator_test
