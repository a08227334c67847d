// A lost camera among places that look alike.
#include <limits>

#include "tests/measure/curve.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tests/tracking/scenes/tiled_wall.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test {
namespace {

using Eigen::Vector3d;

constexpr double kRight_pct = 3;
const Trial kStaysLost{Verdict::kSaidSo, std::numeric_limits<double>::quiet_NaN()};

Trial FoundAt(const Rigid3& found, const Rigid3& truth, double distance) {
  const double off_pct = 100 * (found.OriginInSource() - truth.OriginInSource()).norm() / distance;
  return {off_pct < kRight_pct ? Verdict::kRight : Verdict::kWrong, off_pct};
}

// A wall of tiles that a row of views has mapped, and one more view.
Trial FoundBeforeMosaic(double equal_share, unsigned seed) {
  constexpr double kDistance = 1.8, kWall_z = 3, kReach = 2;
  const CameraModel camera = CameraModel::Pinhole(320, 240, 260);
  const TexturedRoom room({.furniture = Furniture::kMosaic, .seed = seed, .equal_share = equal_share});
  Draw draw(seed);
  const auto at = [&](double x) {
    const Vector3d center(x, draw.Uniform(-0.2, 0.2), kWall_z - kDistance + draw.Uniform(-0.1, 0.1));
    return LookAt(center, {x + draw.Uniform(-0.2, 0.2), 0, kWall_z}, -Vector3d::UnitY());
  };
  std::vector<SeedView> views;
  std::uint64_t id = 0;
  for (double x = -kReach; x <= kReach; x += 0.4) {
    const Rigid3 pose = at(x);
    views.push_back({room.Take(pose, id++, camera).image, pose});
  }
  Tracker tracker(camera, {.deterministic = true, .seed = seed, .features = 400});
  if (!tracker.SeedMap(views)) return kStaysLost;
  const Rigid3 truth = at(draw.Uniform(0.5 - kReach, kReach - 0.5));
  const Track track = tracker.Step(room.Take(truth, id, camera));
  return track.cam_from_world ? FoundAt(*track.cam_from_world, truth, kDistance) : kStaysLost;
}

// Places one after the other along a wall, each as wide as two pictures.
Trial FoundAmongPlaces(double alike_share, unsigned seed) {
  constexpr double kPlace = 2, kPlaces = 8;
  const TiledWall wall({.period = kPlace,
                        .unique_share = 1 - alike_share,
                        .seed = seed,
                        .mapped = kPlace * kPlaces,
                        .keyframe_step = 0.25});
  Draw draw(seed + 100);
  const Rigid3 truth = TiledWall::PoseAt(
      draw.Uniform(0.5 * TiledWall::kWidth, (kPlace * kPlaces - 0.5) * TiledWall::kWidth), draw);
  const auto found = wall.Find(truth, draw);
  return found ? FoundAt(found->cam_from_world, truth, TiledWall::kDepth) : kStaysLost;
}

// Where the wall goes on and the map does not.
Trial FoundBeyondTheMap(double equal_share, unsigned seed) {
  const TiledWall wall({.unique_share = 1 - equal_share, .seed = seed});
  Draw draw(seed + 100);
  const Rigid3 truth =
      TiledWall::PoseAt(draw.Uniform(TiledWall::kMapped + TiledWall::kWidth, 2 * TiledWall::kMapped), draw);
  const auto found = wall.Find(truth, draw);
  if (!found) return {Verdict::kRight, 0};
  return {Verdict::kWrong,
          100 * (found->cam_from_world.OriginInSource() - truth.OriginInSource()).norm() / TiledWall::kDepth};
}

CURVE(found_among_equal_tiles,
      {.stage = "Relocalisation",
       .title = "A wall of equal tiles",
       .about =
           R"(A map of 11 views along a wall of tiles; a lost tracker is shown one more. Right: its centre
  is off by less than 3 % of the distance (the next tile is 22 % away); staying lost says so.)",
       .driven = {{"tiles that are equal [%]"}, {0, 20, 40, 60, 80, 90, 95, 100}, 20, 100},
       .error = Log("the centre is off by [% of the distance]"),
       .trial = [](double percent, unsigned seed) { return FoundBeforeMosaic(percent / 100, seed); },
       .rarely_wrong = 0.1,
       .why_wrong = "where nine tiles in ten are equal, a picture may agree better with another place than "
                    "with its own, and the error predicted there knows nothing of it."});

CURVE(found_among_equal_places,
      {.stage = "Relocalisation",
       .title = "Places that look alike",
       .about = R"(A map of eight places along a wall that have a share of their points in common; points
  and descriptors are drawn. Right: off by less than 3 % of the distance (the next place is 240 % away);
  staying lost says so.)",
       .driven = {{"points that all places have [%]"}, {0, 30, 50, 60, 70, 80, 90, 95, 100}, 50, 100},
       .error = Log("the centre is off by [% of the distance]"),
       .trial = [](double percent, unsigned seed) { return FoundAmongPlaces(percent / 100, seed); }});

CURVE(lost_beyond_the_map,
      {.about = R"(A camera before a part of a wall of tiles that is not in the map. Right: it stays lost.)",
       .driven = {{"points that every tile has [%]"}, {0, 20, 40, 60, 80, 90, 95, 100}, 40, 100},
       .trial = [](double percent, unsigned seed) { return FoundBeyondTheMap(percent / 100, seed); },
       .never_breaks = "to stay lost is right, and no two tiles can be more alike"});

}  // namespace
}  // namespace ulf::test
