// Tests: core/base/clock_offset.
#include "core/base/clock_offset.h"

#include <gmock/gmock.h>

#include <random>

namespace ulf::clock_offset_test {
namespace {

TEST(ClockOffset, IsTheLeastDelayAndTheSpreadRoundIt) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::mt19937 random(seed);
    std::exponential_distribution<double> waiting_s(1 / 0.004);  // mean and standard deviation 4 ms
    ClockOffset clock;
    EXPECT_FALSE(clock.OffsetS());
    for (int i = 0; i < 800; ++i) {
      const double device_s = 1000 + i / 30.0;
      clock.Add(device_s, device_s + 1.7e9 + 0.010 + waiting_s(random));
    }
    EXPECT_NEAR(*clock.OffsetS(), 1.7e9 + 0.010, 1e-4) << seed;
    EXPECT_NEAR(*clock.JitterS(), 0.004, 0.0006) << seed;
    EXPECT_NEAR(clock.LatenessS(2000, 2000 + 1.7e9 + 0.110), 0.1, 1e-4) << seed;
  }
}

TEST(ClockOffset, FollowsADriftingClock) {
  ClockOffset clock;
  const double drift = 100e-6;
  for (int i = 0; i < 30 * 600; ++i) {
    const double host_s = i / 30.0;
    clock.Add(host_s * (1 - drift), host_s);
  }
  // After ten minutes the clocks are 60 ms apart; a minute's memory leaves 6 ms of that.
  EXPECT_NEAR(*clock.OffsetS(), 600 * drift, 60 * drift + 1e-6);
  EXPECT_LT(*clock.JitterS(), 60 * drift);
}

// The host's clock is set back by an hour, and what was measured before says nothing any more.
TEST(ClockOffset, BeginsAnewWhereTheHostsClockIsSetBack) {
  ClockOffset clock;
  for (int i = 0; i < 30 * 60; ++i) clock.Add(i / 30.0, 5000 + i / 30.0);
  for (int i = 0; i < 30 * 600; ++i) {
    const double device_s = 60 + i / 30.0;
    clock.Add(device_s, 1400 + device_s * (1 + 100e-6));
  }
  // Ten minutes later it has followed the drift since, which a window that waits for the old hour would not.
  EXPECT_NEAR(*clock.OffsetS(), 1400 + 660 * 100e-6, 61 * 100e-6);
  EXPECT_LT(*clock.JitterS(), 60 * 100e-6);
}

}  // namespace
}  // namespace ulf::clock_offset_test
