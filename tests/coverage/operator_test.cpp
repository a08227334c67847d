// Simulated people against the promise: a novice covers the whole cap without training. Without pictures; the
// same with pictures and the tracker is in operator_capture_test.cpp.
#include <gmock/gmock.h>

#include "acquisition/error.h"
#include "tests/support/imagined_capture.h"

namespace ulf::test {
namespace {

#ifdef ULF_ALL_SEEDS
constexpr std::uint64_t kSeeds = 20;
#else
constexpr std::uint64_t kSeeds = 2;
#endif
constexpr std::uint64_t kFirstSeed = 101;  // guidance was made with 1 to 5

TEST(SimulatedOperator, CoversTheCapGuidedAndAsANovice) {
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kSeeds; ++seed)
    for (const bool novice : {false, true})
      for (const double size : {0.28, 0.2}) {
        const ImaginedResult result =
            RunImagined({.person = {.novice = novice, .seed = seed}, .subject_size = size});
        const std::string who = (novice ? "novice " : "guided ") + std::to_string(seed);
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

TEST(SimulatedOperator, TheSameSeedIsTheSamePersonOnTheSameDay) {
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
    EXPECT_THROW(OperatorOptions::Parse(text), UsageError) << text;
}

}  // namespace
}  // namespace ulf::test
