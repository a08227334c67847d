// Tests: tracking/map/anchored, tracking/map/map, tracking/map/map_adjustment, tracking/map/map_file,
// tracking/map/map_matching, tracking/map/relocalizer.
#include "tracking/map/map.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <unordered_map>

#include "core/geometry/angles.h"
#include "core/geometry/digest.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/mapped_wall.h"
#include "tracking/map/map_adjustment.h"
#include "tracking/map/map_file.h"
#include "tracking/map/map_matching.h"
#include "tracking/map/relocalizer.h"

namespace ulf::map_test {
namespace {

using test::Disturbed;
using test::Draw;
using test::RandomDescriptor;
using World = test::MappedWall;

TEST(MapTest, ObservationsLinkBothWaysThroughEveryChange) {
  World world(5);
  world.ExpectConsistent();
  const int victim = world.map.keyframe(2).point_of_feature[3];
  world.map.RemovePoint(victim);
  world.ExpectConsistent();
  EXPECT_EQ(world.map.Resolve(victim), -1);
  world.map.RemoveKeyframe(3);
  world.ExpectConsistent();
  world.map.RemovePart(0);
  world.ExpectConsistent();
  EXPECT_EQ(world.map.LivingPoints(), 0);
  EXPECT_EQ(world.map.LivingKeyframes(), 0);
  EXPECT_EQ(world.map.FirstKeyframe(0), -1);
}

TEST(MapTest, APointWithOneObservationGoes) {
  World world(4);
  for (const int id : world.points) {
    if (world.map.point(id).observations.size() != 2) continue;
    world.map.RemoveObservation(id, world.map.point(id).observations[0].keyframe);
    EXPECT_FALSE(world.map.point(id).alive);
    world.ExpectConsistent();
    return;
  }
  FAIL() << "no point with two observations in the scene";
}

TEST(MapTest, MergedPointsSayWhereTheyWent) {
  World world(4);
  int a = -1, b = -1;  // seen by different keyframes
  for (const int id : world.points)
    for (const int other : world.points) {
      if (a >= 0 || id == other || world.map.point(id).observations.empty() ||
          world.map.point(other).observations.empty())
        continue;
      if (world.map.point(id).observations.back().keyframe <
          world.map.point(other).observations.front().keyframe) {
        a = id;
        b = other;
      }
    }
  ASSERT_GE(a, 0);
  const std::size_t together =
      world.map.point(a).observations.size() + world.map.point(b).observations.size();
  world.map.Merge(a, b);
  EXPECT_FALSE(world.map.point(a).alive);
  EXPECT_EQ(world.map.Resolve(a), b);
  EXPECT_EQ(world.map.point(b).observations.size(), together);
  world.ExpectConsistent();
}

TEST(MapTest, AnchorsSurviveTheirKeyframe) {
  World world(5);
  const Eigen::Matrix4d before = world.map.PoseOf(2).Matrix();
  world.map.RemoveKeyframe(2);
  EXPECT_LT((world.map.PoseOf(2).Matrix() - before).norm(), 1e-12);
  // The parent moves, the removed one with it; and so through two removals.
  const int parent = world.map.keyframe(2).parent;
  const Eigen::Matrix4d relative = before * world.map.PoseOf(parent).Inverse().Matrix();
  world.map.keyframe(parent).cam_from_world.translation += Eigen::Vector3d(0.1, 0.2, 0.3);
  EXPECT_LT((world.map.PoseOf(2).Matrix() - relative * world.map.PoseOf(parent).Matrix()).norm(), 1e-12);
  const Eigen::Matrix4d moved = world.map.PoseOf(2).Matrix();
  world.map.RemoveKeyframe(parent);
  EXPECT_LT((world.map.PoseOf(2).Matrix() - moved).norm(), 1e-12);
}

TEST(MapTest, CovisibilityFallsWithDistance) {
  const World world(6);
  const auto neighbours = world.map.Covisible(0, 1);
  ASSERT_GE(neighbours.size(), 1u);
  EXPECT_EQ(neighbours.front().keyframe, 1);
  for (std::size_t i = 1; i < neighbours.size(); ++i)
    EXPECT_LE(neighbours[i].shared, neighbours[i - 1].shared);
}

// With patches and one removed keyframe.
std::string SavedWorld(World& world) {
  world.map.RemoveKeyframe(2);
  for (const int id : world.points) {
    MapPoint& point = world.map.point(id);
    if (!point.alive || id % 3 != 0) continue;
    ReferencePatch patch;
    patch.pixels.fill(static_cast<std::uint8_t>(id));
    patch.level = id % kPyramidLevels;
    point.patch = std::make_shared<const ReferencePatch>(patch);
    point.patch_keyframe = id % 2 == 0 ? 2 : 1;
    point.found = id % 7;
    for (int view = 0; view < id % 4; ++view) world.map.AddView(id, {10 + view, {0.25 * id, 7.5}});
  }
  return MapToBytes(world.map, 77);
}

TEST(MapFileTest, ComesBackAsItWas) {
  World world(5);
  const std::string bytes = SavedWorld(world);
  Map back(world.camera);
  ASSERT_FALSE(MapFromBytes(bytes, 77, world.camera, back));
  EXPECT_EQ(back.LivingPoints(), world.map.LivingPoints());
  EXPECT_EQ(back.LivingKeyframes(), 4);
  EXPECT_LT((back.PoseOf(2).Matrix() - world.map.PoseOf(2).Matrix()).norm(), 1e-12);
  EXPECT_TRUE(back.keyframe(1).pinned);
  EXPECT_EQ(back.keyframe(3).points, world.map.keyframe(3).points);
  const int point = back.keyframe(3).point_of_feature[5], was = world.map.keyframe(3).point_of_feature[5];
  EXPECT_EQ(back.point(point).descriptor, world.map.point(was).descriptor);
  EXPECT_EQ(back.point(point).reference_distance, world.map.point(was).reference_distance);
  std::size_t seen = 0;
  for (const MapPoint& restored : back.points()) seen += restored.views.size();
  EXPECT_GT(seen, 10u);
  EXPECT_EQ(MapToBytes(back, 77), bytes);
}

// The wall once more, as another part with a world of its own.
int AddSecondPart(World& world) {
  Map& map = world.map;
  const int part = 1, keyframes = static_cast<int>(map.keyframes().size());
  for (int k = 0; k < keyframes; ++k) {
    Keyframe copy = map.keyframe(k);
    copy.part = part;
    map.AddKeyframe(std::move(copy));
  }
  const int points = static_cast<int>(map.points().size());
  for (int id = 0; id < points; ++id) {
    const MapPoint point = map.point(id);
    if (!point.alive) continue;
    const int copy = map.AddPoint(point.position, part);
    for (Observation o : point.observations) {
      o.keyframe += keyframes;
      map.AddObservation(copy, o);
    }
    map.Update(copy);
  }
  return part;
}

TEST(MapParts, AreSeenAndSavedApartUntilTheyAreJoined) {
  World world(5), alone(5);
  Map& map = world.map;
  map.BeginPart();
  ASSERT_EQ(map.BeginPart(), 1);
  const Rigid3 pose = map.keyframe(1).cam_from_world;
  const auto gathered = [&](int part) { return GatherCandidates(map, world.camera, pose, part); };
  const std::size_t before = gathered(0).size();
  const int part = AddSecondPart(world);
  EXPECT_EQ(gathered(0).size(), before);
  EXPECT_EQ(gathered(part).size(), before);
  for (const Candidate& candidate : gathered(part)) EXPECT_EQ(map.point(candidate.id).part, part);
  EXPECT_EQ(map.Parts(), (std::vector<int>{0, 1}));
  EXPECT_EQ(map.FirstKeyframe(part), static_cast<int>(alone.map.keyframes().size()));

  // Of the main part alone, under the numbers that keyframes have.
  Map back(world.camera);
  ASSERT_FALSE(MapFromBytes(MapToBytes(map, 77), 77, world.camera, back));
  EXPECT_EQ(back.LivingKeyframes(), alone.map.LivingKeyframes());
  EXPECT_EQ(back.LivingPoints(), alone.map.LivingPoints());

  map.JoinPart(part, 0);
  EXPECT_EQ(map.Parts(), (std::vector<int>{0}));
  EXPECT_EQ(gathered(0).size(), 2 * before);
  EXPECT_TRUE(gathered(part).empty());
}

TEST(MapParts, OneIsRemovedAndTheOtherStays) {
  World world(5), alone(5);
  const int part = AddSecondPart(world);
  const Rigid3 last = world.map.PoseOf(world.map.FirstKeyframe(part));
  const int first = world.map.FirstKeyframe(part);
  world.map.RemovePart(part);
  EXPECT_EQ(world.map.Parts(), (std::vector<int>{0}));
  EXPECT_EQ(world.map.LivingPoints(), alone.map.LivingPoints());
  EXPECT_EQ(world.map.LivingKeyframes(), alone.map.LivingKeyframes());
  EXPECT_EQ(world.map.PoseOf(first).Matrix(), last.Matrix());
  EXPECT_EQ(world.map.keyframe(0).points, alone.map.keyframe(0).points);
}

// Images leave each part's world open by itself: neither may drift when all is adjusted.
TEST(MapParts, AdjustingBothKeepsEachWhereItIs) {
  World world(5);
  const int part = AddSecondPart(world);
  OwnedMap owned(std::move(world.map));
  const Map& map = owned.shared.ReadByOwner();
  std::vector<Rigid3> before;
  {
    const MapLock lock(owned.shared);
    // The first keyframe of each is wrong: held, it would turn and move all others.
    for (const int p : {0, part})
      owned.map.keyframe(map.FirstKeyframe(p)).cam_from_world.translation +=
          Eigen::Vector3d(0.03, -0.02, 0.02);
    for (const int id : map.living()) before.push_back(map.keyframe(id).cam_from_world);
  }
  ASSERT_TRUE(AdjustMap(world.camera, owned, map.living(), {}, {}).usable);
  for (const int p : {0, part}) {
    Eigen::Vector3d was = Eigen::Vector3d::Zero(), is = Eigen::Vector3d::Zero();
    const std::vector<int> of_part = map.LivingOf(p);
    for (const int id : of_part) {
      was += before[static_cast<std::size_t>(id)].OriginInSource() / static_cast<double>(of_part.size());
      is += map.keyframe(id).cam_from_world.OriginInSource() / static_cast<double>(of_part.size());
    }
    EXPECT_LT((was - is).norm(), 1e-6) << p;
  }
}

TEST(MapFileTest, RefusesInconsistentContent) {
  World world(4);
  const std::string bytes = SavedWorld(world);
  const auto problem = [&](const std::string& file, std::uint64_t key = 77) -> std::string {
    Map map(world.camera);
    const auto refusal = MapFromBytes(file, key, world.camera, map);
    return refusal ? refusal->words : "";
  };
  EXPECT_EQ(problem(bytes), "");
  EXPECT_NE(problem(bytes, 78).find("views, poses"), std::string::npos);
  EXPECT_NE(problem("").find("no map"), std::string::npos);
  EXPECT_NE(problem("{}").find("no map"), std::string::npos);
  std::string other = bytes;
  other[7] = 9;
  EXPECT_NE(problem(other).find("version"), std::string::npos);
  for (std::size_t length = 0; length < bytes.size(); length += bytes.size() / 40)
    EXPECT_NE(problem(bytes.substr(0, length)), "") << length;
  Draw draw(3);
  for (int i = 0; i < 200; ++i) {
    std::string damaged = bytes;
    const auto at = static_cast<std::size_t>(draw.Uniform(0, static_cast<double>(bytes.size() - 9)));
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (i % 8)));
    EXPECT_NE(problem(damaged), "") << at;
    // A wrong file whose checksum is right is read without harm.
    Digest digest;
    digest.Add(std::as_bytes(std::span(damaged).first(damaged.size() - 8)));
    const std::uint64_t sum = digest.Value();
    std::memcpy(damaged.data() + damaged.size() - 8, &sum, 8);
    problem(damaged);
  }
}

// An hour in which the camera goes on and on: what is dead must cost nothing.
TEST(MapTest, ALongRunNeedsNoMoreRoomThanWhatLives) {
  constexpr int kAlive = 6, kSteps = 400, kPointsEach = 40;
  const CameraModel camera = test::SceneCamera();
  Map map(camera);
  std::vector<Feature> features;
  for (int i = 0; i < kPointsEach; ++i) {
    const Eigen::Vector2d img(20 + 15.0 * i, 240);
    features.push_back({img, *camera.RayFromImg(img), 0, 0, {}});
  }
  const auto set = std::make_shared<const FeatureSet>(features, camera.width, camera.height);
  std::vector<int> points;
  std::size_t after_a_while = 0;
  for (int step = 0; step < kSteps; ++step) {
    Keyframe keyframe;
    keyframe.features = set;
    keyframe.color.create(480, 640, CV_8UC3);
    keyframe.cam_from_world.translation.x() = -0.1 * step;
    const int id = map.AddKeyframe(std::move(keyframe));
    for (int i = 0; i < kPointsEach; ++i) {
      const std::size_t slot = static_cast<std::size_t>(i);
      if (step % 2 == 0) {
        points.push_back(map.AddPoint({0.1 * step, 0, 3}));
        map.AddObservation(points.back(), {id, i, features[slot].img, 1});
      } else {
        map.AddObservation(points[points.size() - kPointsEach + slot], {id, i, features[slot].img, 1});
      }
    }
    if (step >= kAlive) map.RemoveKeyframe(map.FirstKeyframe(0));
    if (step == 100) after_a_while = map.points().size();
  }
  EXPECT_EQ(map.LivingKeyframes(), kAlive);
  EXPECT_EQ(map.points().size(), after_a_while);
  EXPECT_LE(map.LivingPoints(), kAlive * kPointsEach);
  for (const Keyframe& keyframe : map.keyframes()) {
    if (keyframe.alive) continue;
    EXPECT_TRUE(keyframe.color.empty() && !keyframe.features && keyframe.point_of_feature.empty());
    // Every anchor hangs on a living keyframe directly, however many have gone since.
    EXPECT_TRUE(map.keyframe(keyframe.parent).alive);
    EXPECT_NEAR(map.PoseOf(keyframe.id).translation.x(), -0.1 * keyframe.id, 1e-9);
  }
}

TEST(MapTest, APointsNumberRestsBeforeItIsGivenAgain) {
  World world(4);
  const auto next_keyframe = [&] {
    Keyframe keyframe;
    keyframe.features = world.map.keyframe(0).features;
    world.map.AddKeyframe(std::move(keyframe));
  };
  const int victim = world.map.keyframe(1).point_of_feature[3];
  world.map.RemovePoint(victim);
  for (int k = 0; k < Map::kPointReuseKeyframes; ++k) {
    EXPECT_NE(world.map.AddPoint({0, 0, 3}), victim) << k;
    EXPECT_EQ(world.map.Resolve(victim), -1);
    next_keyframe();
  }
  EXPECT_EQ(world.map.AddPoint({0, 0, 3}), victim);
  EXPECT_EQ(world.map.Resolve(victim), victim);
}

// A whole map's adjustment moves nothing that the images leave open.
TEST(MapTest, AdjustingEverythingKeepsTheMapWhereItIs) {
  World world(6);
  // The first keyframe is the one that is wrong: held, it would turn and move all others.
  world.map.keyframe(0).cam_from_world.translation += Eigen::Vector3d(0.03, -0.02, 0.02);
  OwnedMap owned(world.map);
  const Map& map = owned.shared.ReadByOwner();
  const auto mean_center = [&] {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const int id : map.living())
      mean += map.keyframe(id).cam_from_world.OriginInSource() / map.LivingKeyframes();
    return mean;
  };
  const Eigen::Vector3d before = mean_center();
  const Eigen::Vector3d fourth = map.keyframe(4).cam_from_world.OriginInSource();
  const BundleSummary summary = AdjustMap(world.camera, owned, map.living(), {},
                                          {.robust_iterations = 20, .iterations = 20, .gate_sigmas = 100});
  ASSERT_TRUE(summary.usable);
  EXPECT_LT(summary.final_rms_sigmas, 0.05);
  EXPECT_LT((mean_center() - before).norm(), 1e-9);
  EXPECT_LT((map.keyframe(4).cam_from_world.OriginInSource() - fourth).norm(), 0.03);
}

// Turned on the spot, as far apart as the poses are wrong: the places say nothing of how the world lies.
TEST(MapTest, AdjustingAMapOfATurningCameraDoesNotTurnIt) {
  Draw draw(5);
  const CameraModel camera = test::SceneCamera();
  Map map(camera);
  std::vector<int> points;
  for (int i = 0; i < 900; ++i) {
    const double azimuth = draw.Uniform(-0.6, 1.9), distance = draw.Uniform(3, 4);
    points.push_back(
        map.AddPoint({distance * std::sin(azimuth), draw.Uniform(-1.2, 1.2), distance * std::cos(azimuth)}));
  }
  std::vector<Rigid3> given;
  for (int k = 0; k < 8; ++k) {
    const auto about = [](double radians) {
      return Eigen::Quaterniond(Eigen::AngleAxisd(radians, Eigen::Vector3d::UnitY()));
    };
    const Eigen::Quaterniond turned = about(-k * M_PI / 18);
    const Eigen::Vector3d center(draw.Normal(0.01), draw.Normal(0.01), draw.Normal(0.01));
    const Rigid3 pose{turned, -(turned * center)};
    std::vector<Feature> features;
    std::vector<int> seen;
    for (const int point : points) {
      const Eigen::Vector3d in_camera = pose * map.point(point).position;
      const auto img = in_camera.z() > 0.5 ? camera.ImgFromCam(in_camera) : std::nullopt;
      if (!img || !camera.Contains(*img)) continue;
      features.push_back({*img, *camera.RayFromImg(*img), 0, 0, {}});
      seen.push_back(point);
    }
    Keyframe keyframe;
    keyframe.cam_from_world = pose;
    keyframe.cam_from_world.translation +=
        Eigen::Vector3d(draw.Normal(0.03), draw.Normal(0.03), draw.Normal(0.03));
    given.push_back(keyframe.cam_from_world);
    keyframe.features = std::make_shared<const FeatureSet>(features, camera.width, camera.height);
    const int id = map.AddKeyframe(std::move(keyframe));
    for (std::size_t i = 0; i < seen.size(); ++i)
      map.AddObservation(seen[i], {id, static_cast<int>(i), features[i].img, 1});
  }
  for (const int point : points) map.Update(point);
  OwnedMap owned(map);
  const Map& adjusted = owned.shared.ReadByOwner();
  const BundleSummary summary = AdjustMap(camera, owned, map.living(), {},
                                          {.robust_iterations = 20, .iterations = 20, .gate_sigmas = 100});
  ASSERT_TRUE(summary.usable);
  EXPECT_LT(summary.final_rms_sigmas, 0.05);
  for (int k = 0; k < 8; ++k)
    EXPECT_LT(Degrees(RotationAngle(adjusted.keyframe(k).cam_from_world.rotation *
                                    given[static_cast<std::size_t>(k)].rotation.conjugate())),
              0.5)
        << k;
}

// Keys that many keyframes share speak for none of them, however rare the feature's other keys are.
TEST(KeyframeIndexTest, CommonKeysBringHardlyAnyVotes) {
  Draw draw(3);
  const CameraModel camera = test::SceneCamera();
  const Descriptor common = RandomDescriptor(draw);
  constexpr int kKeyframes = 6, kWanted = 5, kFeatures = 30;
  KeyframeIndex index(1);
  std::vector<Feature> wanted;
  for (int k = 0; k < kKeyframes; ++k) {
    std::vector<Feature> features;
    for (int i = 0; i < kFeatures; ++i)
      features.push_back({{320, 240}, {0, 0, 1}, 0, 0, Disturbed(common, 12, draw)});
    Keyframe keyframe;
    keyframe.id = k;
    keyframe.features = std::make_shared<const FeatureSet>(features, camera.width, camera.height);
    keyframe.point_of_feature.assign(kFeatures, 0);
    index.Add(keyframe);
    if (k == kWanted) wanted = features;
  }
  for (Feature& feature : wanted) feature.descriptor = Disturbed(feature.descriptor, 4, draw);
  const auto ranked = index.Query(FeatureSet(wanted, camera.width, camera.height), kKeyframes);
  ASSERT_GE(ranked.size(), 2u);
  EXPECT_EQ(ranked[0].keyframe, kWanted);
  EXPECT_GT(ranked[0].votes, 2 * ranked[1].votes);
}

TEST(KeyframeIndexTest, RanksTheRightKeyframeFirst) {
  const World world(8);
  KeyframeIndex index(1);
  for (const Keyframe& keyframe : world.map.keyframes()) index.Add(keyframe);
  Draw draw(9);
  for (const int wanted : {0, 3, 7}) {
    std::vector<Feature> features = world.map.keyframe(wanted).features->all();
    for (Feature& feature : features) feature.descriptor = Disturbed(feature.descriptor, 20, draw);
    const FeatureSet query(features, 640, 480);
    const auto ranked = index.Query(query, 3);
    ASSERT_FALSE(ranked.empty());
    EXPECT_EQ(ranked.front().keyframe, wanted);
  }
  index.Remove(3);
  const auto without = index.Query(*world.map.keyframe(3).features, 8);
  for (const auto& ranked : without) EXPECT_NE(ranked.keyframe, 3);
}

TEST(KeyframeIndexTest, ProposesPosesAndNoneByChance) {
  const World world(5);
  Draw draw(4);
  const Rigid3 truth{Eigen::Quaterniond(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY())),
                     {-2.2, 0.1, 0.05}};
  std::vector<Feature> features;
  for (const MapPoint& point : world.map.points()) {
    const auto img = world.camera.ImgFromCam(truth * point.position);
    if (!img || !world.camera.Contains(*img) || point.observations.empty()) continue;
    features.push_back({*img, *world.camera.RayFromImg(*img), 0, 0, Disturbed(point.descriptor, 25, draw)});
  }
  const auto found = ProposePose(world.camera, PointsOf(world.map, 2), FeatureSet(features, 640, 480), 1);
  ASSERT_TRUE(found);
  EXPECT_LT((found->OriginInSource() - truth.OriginInSource()).norm(), 0.01);
  for (Feature& feature : features) feature.descriptor = RandomDescriptor(draw);
  EXPECT_FALSE(ProposePose(world.camera, PointsOf(world.map, 2), FeatureSet(features, 640, 480), 1));
}

TEST(GatherCandidatesNearTest, TakesNearAtOnceRestInTurn) {
  const World world(300);
  const int here = 80;
  const Rigid3& pose = world.map.keyframe(here).cam_from_world;
  ASSERT_GT(static_cast<int>(world.points.size()), 2 * kSweptPoints);
  const auto ids_of = [](const std::vector<Candidate>& candidates) {
    std::set<int> ids;
    for (const Candidate& candidate : candidates) ids.insert(candidate.id);
    EXPECT_EQ(ids.size(), candidates.size()) << "a point was taken twice";
    return ids;
  };
  const std::set<int> whole = ids_of(GatherCandidates(world.map, world.camera, pose));
  ASSERT_GT(whole.size(), 100u);

  // Known from the frame before: a few points lead to the keyframes that see all of them.
  std::unordered_map<int, Eigen::Vector2d> seen_before;
  for (const int id : world.map.keyframe(here).point_of_feature)
    if (seen_before.size() < 20) seen_before.emplace(id, Eigen::Vector2d(0, 0));
  int sweep = 0;
  EXPECT_EQ(ids_of(GatherCandidatesNear(world.map, world.camera, pose, seen_before, sweep)), whole);

  // Nothing known: the map comes by in turn, whole, and again and again.
  sweep = 0;
  const int turns = static_cast<int>(world.map.points().size()) / kSweptPoints + 1;
  for (int again = 0; again < 2; ++again) {
    std::set<int> swept;
    for (int turn = 0; turn < turns; ++turn) {
      const std::set<int> now = ids_of(GatherCandidatesNear(world.map, world.camera, pose, {}, sweep));
      EXPECT_LT(now.size(), whole.size());
      swept.insert(now.begin(), now.end());
    }
    EXPECT_EQ(swept, whole);
  }
}

}  // namespace
}  // namespace ulf::map_test
