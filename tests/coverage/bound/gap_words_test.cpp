// Tests: coverage/bound/gap_words.
#include "coverage/bound/gap_words.h"
#include "tests/support/floors.h"

#include <gtest/gtest.h>

namespace ulf {
namespace {

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
}  // namespace ulf
