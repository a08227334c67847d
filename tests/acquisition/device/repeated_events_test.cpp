// Tests: acquisition/device/repeated_events.
#include "acquisition/device/repeated_events.h"
#include "tests/support/floors.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace ulf::repeated_events_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;

DeviceEvent Stall(double at_s) { return {DeviceEventKind::kStalled, at_s, "no frame for 0.5 s", 0.5}; }
DeviceEvent Again(double at_s, double silence_s) {
  return {DeviceEventKind::kNotice, at_s, fmt::format("frames come again after {:.1f} s", silence_s),
          silence_s};
}

TEST(RepeatedEvents, SayTheFirstAndSummariseTheRest) {
  RepeatedEvents repeated({.every_s = 30});
  EXPECT_THAT(repeated.Update({Stall(100)}, 100), ElementsAre("no frame for 0.5 s"));
  EXPECT_THAT(repeated.Update({Again(100, 0.5)}, 100), ElementsAre("frames come again after 0.5 s"));
  for (int i = 1; i < 12; ++i)
    EXPECT_THAT(repeated.Update({Stall(100 + i), Again(100.2 + i, 0.5)}, 100.2 + i), IsEmpty()) << i;
  EXPECT_THAT(repeated.Update({}, 129), IsEmpty());
  EXPECT_THAT(repeated.Update({}, 130.5),
              ElementsAre(MatchesRegex("no frame for 6 s \\(12 times since [0-9][0-9]:[0-9][0-9]\\)")));
  EXPECT_THAT(repeated.Update({}, 300), IsEmpty()) << "nothing new";
  EXPECT_THAT(repeated.Finish(), IsEmpty());
}

TEST(RepeatedEvents, PendingOnesAreSaidAtTheEnd) {
  RepeatedEvents repeated;
  repeated.Update({Stall(0)}, 0);
  EXPECT_THAT(repeated.Update({Again(3, 3.5), Stall(4)}, 4), ElementsAre("frames come again after 3.5 s"));
  EXPECT_THAT(repeated.Finish(), ElementsAre(MatchesRegex("no frame for 4 s \\(2 times since .*\\)")));
  EXPECT_THAT(repeated.Finish(), IsEmpty());
}

TEST(RepeatedEvents, EqualNoticesAreCollected) {
  RepeatedEvents repeated({.every_s = 10});
  const auto notice = [](const std::string& text) { return DeviceEvent{DeviceEventKind::kNotice, 0, text}; };
  EXPECT_THAT(repeated.Update({notice("the camera is busy"), notice("not downloaded: IMG_1")}, 0),
              ElementsAre("the camera is busy", "not downloaded: IMG_1"));
  EXPECT_THAT(repeated.Update({notice("the camera is busy"), notice("not downloaded: IMG_2")}, 1),
              ElementsAre("not downloaded: IMG_2"));
  EXPECT_THAT(repeated.Update({}, 11),
              ElementsAre(MatchesRegex("the camera is busy \\(2 times since .*\\)")));
}

TEST(RepeatedEvents, LossesOfTheCameraAreSaidEach) {
  RepeatedEvents repeated;
  for (int i = 0; i < 3; ++i)
    EXPECT_THAT(repeated.Update({{DeviceEventKind::kFaulted, 1.0 * i, "the cable is out"},
                                 {DeviceEventKind::kRestored, 1.0 * i, "streams again"}},
                                i),
                ElementsAre("the cable is out", "streams again"));
}

}  // namespace
}  // namespace ulf::repeated_events_test
