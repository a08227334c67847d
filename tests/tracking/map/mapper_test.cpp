// Tests: tracking/map/frame_report, tracking/map/mapper, tracking/map/mapper_options,
// tracking/map/mapper_points.
#include "tracking/map/mapper.h"

#include <gtest/gtest.h>

#include <type_traits>
#include <utility>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/mapped_wall.h"

namespace ulf::mapper_test {
namespace {

using World = test::MappedWall;

// Whoever is not the mapper has a map to read.
template <typename Shared>
concept CanChangeTheMap = requires(Shared& shared) {
  shared.map.AddPoint(Eigen::Vector3d::Zero());
};
template <typename Shared>
concept CanMoveTheWorld = requires(Shared& shared) {
  shared.world_given = true;
};
using Given = decltype(std::declval<Mapper&>().shared());
static_assert(!CanChangeTheMap<std::remove_reference_t<Given>> &&
              !CanMoveTheWorld<std::remove_reference_t<Given>>);
static_assert(!CanChangeTheMap<SharedMap>);
static_assert(CanChangeTheMap<OwnedMap>);

// A keyframe that sees what another one sees.
NewKeyframe LikeKeyframe(const Map& map, int id, double time_s) {
  const Keyframe& seen = map.keyframe(id);
  NewKeyframe offered;
  offered.keyframe.time_s = time_s;
  offered.keyframe.cam_from_world = seen.cam_from_world;
  offered.keyframe.features = seen.features;
  for (int i = 0; i < seen.features->size(); ++i)
    if (const int point = seen.point_of_feature[static_cast<std::size_t>(i)]; point >= 0)
      offered.seen.push_back({point, {-1, i, (*seen.features)[i].img, 1}});
  return offered;
}

// Two points in one place, each known to two keyframes of the four that see it: they become one.
TEST(MapperTest, DuplicatesMerge) {
  World world(4);
  int split = 0;
  for (const int id : world.points) {
    const std::vector<Observation> seen = world.map.point(id).observations;
    if (seen.size() < 4 || split >= 20) continue;
    const int copy = world.map.AddPoint(world.map.point(id).position + Eigen::Vector3d(1e-3, 0, 0));
    for (std::size_t i = 2; i < seen.size(); ++i) {
      world.map.RemoveObservation(id, seen[i].keyframe);
      ASSERT_TRUE(world.map.AddObservation(copy, seen[i]));
    }
    world.map.Update(id);
    world.map.Update(copy);
    ++split;
  }
  ASSERT_GE(split, 5);
  const int before = world.map.LivingPoints();
  Mapper mapper(world.camera, world.map, true);
  const Map& map = mapper.shared().ReadByOwner();
  NewKeyframe offered;
  const Keyframe& last = map.keyframe(3);
  offered.keyframe.cam_from_world = last.cam_from_world;
  offered.keyframe.features = last.features;
  for (int i = 0; i < last.features->size(); ++i)
    if (last.point_of_feature[static_cast<std::size_t>(i)] >= 0)
      offered.seen.push_back(
          {last.point_of_feature[static_cast<std::size_t>(i)], {-1, i, (*last.features)[i].img, 1}});
  ASSERT_TRUE(mapper.Take({.keyframe = std::move(offered)}));
  EXPECT_LE(map.LivingPoints(), before - split * 3 / 4);
}

TEST(MapperTest, CountsWhatFramesShouldHaveSeenAndSaw) {
  World world(4);
  Mapper mapper(world.camera, world.map, true);
  const Map& map = mapper.shared().ReadByOwner();
  const int found = world.points[0], missed = world.points[1];
  EXPECT_TRUE(mapper.Take({.expected = {found, missed}, .found = {found}}));
  EXPECT_TRUE(mapper.Take({.expected = {found}, .found = {found}}));
  EXPECT_EQ(map.point(found).expected, 2);
  EXPECT_EQ(map.point(found).found, 2);
  EXPECT_EQ(map.point(missed).expected, 1);
  EXPECT_EQ(map.point(missed).found, 0);
}

TEST(MapperTest, SetsVelocityOnlyOnItsKeyframe) {
  World world(4);
  world.map.keyframe(3).time_s = 5;
  Mapper mapper(world.camera, world.map, true);
  const Map& map = mapper.shared().ReadByOwner();
  mapper.Take({.velocity = FrameReport::KeyframeVelocity{4, Twist::Ones()}});
  EXPECT_FALSE(map.keyframe(3).velocity);
  mapper.Take({.velocity = FrameReport::KeyframeVelocity{5, Twist::Ones()}});
  ASSERT_TRUE(map.keyframe(3).velocity);
  EXPECT_EQ(*map.keyframe(3).velocity, Twist(Twist::Ones()));
}

// What frames say is in the map at once, also while the mapper's thread works on a keyframe.
TEST(MapperTest, TakesReportsBesideItsThread) {
  World world(6);
  Mapper mapper(world.camera, world.map, false);
  const SharedMap& shared = mapper.shared();
  const int point = world.points[0];
  int taken = 0;
  for (int k = 0; k < 20; ++k) {
    FrameReport report{.expected = {point}, .found = {}};
    {
      const MapLock lock(shared);
      report.keyframe = LikeKeyframe(shared.map, shared.map.living().back(), 10 + k);
    }
    taken += mapper.Take(std::move(report));
    const MapLock lock(shared);
    const MapPoint& seen = shared.map.point(point);
    EXPECT_TRUE(!seen.alive || seen.expected == k + 1) << seen.expected;
  }
  mapper.Drain();
  EXPECT_GE(taken, 1);
  EXPECT_EQ(static_cast<int>(mapper.shared().ReadByOwner().keyframes().size()), 6 + taken);
}

TEST(MapperTest, NotesViewsOfMergedPoints) {
  World world(4);
  const int kept = world.points[0], gone = world.points[1], removed = world.points[2];
  world.map.Merge(gone, kept);
  world.map.RemovePoint(removed);
  Mapper mapper(world.camera, world.map, true);
  const std::vector<MapObservation> seen{{gone, {1, 2}, 1}, {removed, {3, 4}, 1}};
  mapper.NoteView(7, seen);
  const MapPoint& point = mapper.shared().ReadByOwner().point(kept);
  ASSERT_EQ(point.views.size(), 1u);
  EXPECT_EQ(point.views[0].view_id, 7);
  EXPECT_EQ(point.views[0].in_img, Eigen::Vector2d(1, 2));
}

// A map that comes from a file is in the index.
TEST(MapperTest, FilesTheKeyframesThatItStartsWith) {
  const World world(4);
  const Mapper mapper(world.camera, world.map, true);
  const auto ranked = mapper.index().Query(*world.map.keyframe(2).features, 1);
  ASSERT_EQ(ranked.size(), 1u);
  EXPECT_EQ(ranked[0].keyframe, 2);
}

TEST(MapperTest, ForgetsEverythingWithItsLastPart) {
  World world(4);
  Mapper mapper(world.camera, world.map, true);
  mapper.MoveWorld({});
  EXPECT_TRUE(mapper.shared().world_given);
  mapper.RemovePart(0);
  EXPECT_FALSE(mapper.shared().world_given);
  EXPECT_EQ(mapper.shared().ReadByOwner().LivingPoints(), 0);
  EXPECT_TRUE(mapper.index().Query(*world.map.keyframe(2).features, 1).empty());
}

}  // namespace
}  // namespace ulf::mapper_test
