// Tests: tracking/map/map_rows, tracking/tracker/readout_estimator.
#include "tracking/map/map_rows.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/mapped_wall.h"
#include "tracking/tracker/readout_estimator.h"

namespace ulf {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using World = test::MappedWall;

constexpr double kReadout_s = 0.02;

// A hand that moves along the wall, up and down, and turns.
Twist VelocityAt(int keyframe) {
  Twist velocity;
  velocity << 0.1 * std::sin(keyframe), 0.1 * std::cos(2 * keyframe), 0.2 * std::sin(3 * keyframe),
      0.8 * std::cos(keyframe), 0.6 * std::sin(2 * keyframe), 0.1;
  return velocity;
}

// Moves every observation to where rows that are read one after the other show it.
void ReadByRows(World& world, double readout_s) {
  for (const int id : world.map.living()) {
    Keyframe& keyframe = world.map.keyframe(id);
    keyframe.velocity = VelocityAt(id);
    const RowShift rows(world.camera, readout_s, *keyframe.velocity, {world.camera, {}});
    for (const int point : keyframe.point_of_feature)
      for (Observation& o : world.map.point(point).observations)
        if (o.keyframe == id)
          o.img = rows.Seen(o.img, keyframe.cam_from_world * world.map.point(point).position);
  }
}

double LargestErrorPx(const World& world, int keyframe) {
  double largest = 0;
  const Keyframe& by = world.map.keyframe(keyframe);
  for (const int point : by.point_of_feature)
    for (const Observation& o : world.map.point(point).observations)
      if (o.keyframe == keyframe)
        largest = std::max(
            largest,
            (*world.camera.ImgFromCam(by.cam_from_world * world.map.point(point).position) - o.img).norm());
  return largest;
}

TEST(GiveRowsTest, TakesTheRowsMotionOutAndBackIn) {
  World world(4);
  ReadByRows(world, kReadout_s);
  world.map.keyframe(2).velocity.reset();
  const double bent_px = LargestErrorPx(world, 1), unknown_px = LargestErrorPx(world, 2);
  ASSERT_GT(bent_px, 0.3);
  GiveRows(world.camera, world.map, kReadout_s);
  EXPECT_LT(LargestErrorPx(world, 1), 1e-6);
  EXPECT_NEAR(LargestErrorPx(world, 2), unknown_px, 1e-9) << "its velocity is not known";
  ASSERT_TRUE(world.map.keyframe(1).rows);
  EXPECT_DOUBLE_EQ(world.map.keyframe(1).rows->readout_s(), kReadout_s);
  GiveRows(world.camera, world.map, 0);
  EXPECT_FALSE(world.map.keyframe(1).rows);
  EXPECT_NEAR(LargestErrorPx(world, 1), bent_px, 1e-3);
}

TEST(EstimateReadoutTest, FindsTheReadoutAndNoneOfAGlobalShutter) {
  for (const double readout_s : {0.0, 0.005, 0.02, -0.02}) {
    World world(12);
    ReadByRows(world, readout_s);
    const auto estimate = EstimateReadout(world.camera, world.map);
    ASSERT_TRUE(estimate) << readout_s;
    EXPECT_NEAR(estimate->readout_s, readout_s, 0.001 + 0.05 * std::abs(readout_s)) << readout_s;
    EXPECT_EQ(estimate->keyframes, 11) << "the newest is left out";
  }
}

TEST(EstimateReadoutTest, NeedsKeyframesEnough) {
  World world(5);
  ReadByRows(world, kReadout_s);
  EXPECT_FALSE(EstimateReadout(world.camera, world.map));
  EXPECT_TRUE(EstimateReadout(world.camera, world.map, {.least_keyframes = 4}));
}

}  // namespace
}  // namespace ulf
