// Whole real sequences, several seeds: stable, not lucky.
#include <gtest/gtest.h>

#include "tests/support/test_paths.h"
#include "tests/tracking/tracker_data.h"

namespace ulf {
namespace {

TEST(TrackerLong, WholeScan) {
  ULF_NEED_TEST_DATA(folder, "scan_synthetic");
  for (const unsigned seed : {1u, 2u, 3u}) {
    const auto run = test::TrackData(folder, "*.jpg", "groundtruth.txt", 795, seed);
    ASSERT_EQ(run.relocalized.size(), static_cast<std::size_t>(run.lost)) << "seed " << seed;
    EXPECT_LT(run.live.ate_rmse, 0.004) << "seed " << seed;
    EXPECT_LT(run.final.ate_rmse, 0.002) << "seed " << seed;
    EXPECT_LT(run.live.ate_max, 0.02) << "seed " << seed;
  }
}

TEST(TrackerLong, WholeKitchen) {
  ULF_NEED_TEST_DATA(folder, "handheld_kitchen");
  for (const unsigned seed : {1u, 2u, 3u}) {
    const auto run = test::TrackData(folder, "*.color.jpg", "colmap_reference.txt", 600, seed);
    EXPECT_LE(run.first_tracked, 40) << "seed " << seed;
    EXPECT_GE(run.tracked, 0.97 * (600 - run.first_tracked)) << "seed " << seed;
    EXPECT_LT(run.live.ate_rmse, 0.03) << "seed " << seed;
    EXPECT_LT(run.final.ate_rmse, 0.02) << "seed " << seed;
  }
}

}  // namespace
}  // namespace ulf
