// Tests: tracking/map/map_rows, tracking/map/map_adjustment, tracking/map/readout_estimator.
#include "tracking/map/map_rows.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/mapped_wall.h"
#include "tracking/map/loop_closer.h"
#include "tracking/map/map_adjustment.h"
#include "tracking/map/readout_estimator.h"

namespace ulf::map_rows_test {
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

// A keyframe that turns fast, with a velocity that is a third off: the map's adjustment finds
// it, in any unit.
TEST(AdjustedRowsTest, AreFoundWithTheMapAndScaledWithIt) {
  constexpr double kScale = 3;
  World world(6);
  OwnedMap owned(world.map);
  const CameraModel& camera = world.camera;
  const auto twist_of = [](int id) {
    Twist twist = VelocityAt(id);
    twist.head<3>() += Vector3d(0.9 * std::cos(id), 0.9 * std::sin(id), 0.4);
    return twist;
  };
  {
    const MapLock lock(owned.shared);
    Map& map = owned.map;
    for (const int id : map.living()) {
      Keyframe& keyframe = map.keyframe(id);
      const RowShift rows(camera, kReadout_s, twist_of(id), {camera, {}});
      keyframe.velocity = twist_of(id);
      for (const int point : keyframe.point_of_feature)
        for (Observation& o : map.point(point).observations)
          if (o.keyframe == id) o.img = rows.Seen(o.img, keyframe.cam_from_world * map.point(point).position);
      if (id > 0) *keyframe.velocity *= 1.33;
    }
    GiveRows(camera, map, kReadout_s);
    std::vector<std::pair<int, Similarity3>> moved;
    Similarity3 larger;
    larger.scale = kScale;
    for (const int id : map.living())
      moved.emplace_back(id, Similarity3::FromRigid(map.keyframe(id).cam_from_world) * larger.Inverse());
    MoveMap(map, moved);
  }
  const Map& map = owned.shared.ReadByOwner();
  const auto off = [&](int id) {
    Twist expected = twist_of(id);
    expected.tail<3>() *= kScale;
    return (map.keyframe(id).rows->twist() - expected).head<3>().norm();
  };
  Twist given = 1.33 * twist_of(3);
  given.tail<3>() *= kScale;
  EXPECT_LT((*map.keyframe(3).expected_twist - given).norm(), 1e-9);
  EXPECT_LT((map.keyframe(3).rows->twist() - given).norm(), 1e-9);
  double before = 0, held = 0, after = 0;
  for (const int id : map.living()) before += off(id);
  ASSERT_TRUE(AdjustMap(camera, owned, map.living(), {}, {}).usable);
  for (const int id : map.living()) held += off(id);
  EXPECT_DOUBLE_EQ(held, before) << "only when it is asked for";
  ASSERT_TRUE(AdjustMap(camera, owned, map.living(), {}, {}, true).usable);
  for (const int id : map.living()) after += off(id);
  EXPECT_LT(after, 0.85 * before) << "a third off is more than the tracker is trusted to be";
}

TEST(EstimateReadoutTest, FindsItAndNoneOfAGlobalShutter) {
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
  EXPECT_TRUE(EstimateReadout(world.camera, world.map, 4));
}

}  // namespace
}  // namespace ulf::map_rows_test
