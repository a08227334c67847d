// Tests: tracking/map/pose_error.
#include "tracking/map/pose_error.h"

#include <gtest/gtest.h>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/mapped_wall.h"

namespace ulf::pose_error_test {
namespace {

TEST(QualityOfTest, IsOneHalfAtAHundredthOfTheDistance) {
  EXPECT_DOUBLE_EQ(QualityOf(0.02, 2), 0.5);
  EXPECT_DOUBLE_EQ(QualityOf(0, 2), 1);
  EXPECT_LT(QualityOf(0.2, 2), 0.1);
}

TEST(MapBendTest, FallsAsTheParallaxGrows) {
  EXPECT_NEAR(MapBend(0.1), 2 * MapBend(0.2), 1e-9);
  EXPECT_GT(MapBend(0.014), 10) << "0.8 degrees, as a map starts";
  EXPECT_TRUE(std::isfinite(MapBend(0)));
}

TEST(MapDriftEstimateTest, IsHowFarGivenPosesHaveMoved) {
  test::MappedWall world(5);
  MapDriftEstimate drift;
  const double young = drift.CenterSigma(world.map, 3);
  for (int k = 0; k < 5; ++k) drift.Add({k, {}, 1}, world.map.PoseOf(k));
  EXPECT_LE(drift.CenterSigma(world.map, 3), young) << "nothing has moved";
  for (int k = 0; k < 5; ++k) world.map.keyframe(k).cam_from_world.translation.y() += 0.1;
  // Two keyframes' worth of a young map count beside the five.
  EXPECT_NEAR(drift.CenterSigma(world.map, 3), 0.1 * std::sqrt(5.0 / 7), 1e-3);
  drift.Clear();
  EXPECT_DOUBLE_EQ(drift.CenterSigma(world.map, 3), young);
}

}  // namespace
}  // namespace ulf::pose_error_test
