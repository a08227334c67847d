// Tests: coverage/bound/open_directions.
#include "coverage/bound/open_directions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/floors.h"

namespace ulf::test::open_directions_test {
namespace {

using Eigen::Vector3d;

const Subject kSubject{Vector3d::Zero(), 0.15};
const Cap kCap = Cap::ParseDegrees("60x40");
const Vector3d kUp = Vector3d::UnitZ();

CriterionView ViewAt(double azimuth_deg, double elevation_deg) {
  CriterionView camera;
  camera.fx = camera.fy = 600;
  camera.width = 640, camera.height = 480, camera.cx = 320, camera.cy = 240;
  const CapFrame frame(Vector3d::UnitX(), kUp);
  return camera.AimedAt(Vector3d::Zero(),
                        frame.Direction(azimuth_deg * M_PI / 180, elevation_deg * M_PI / 180), kUp);
}

CoverageMap MapOf(const std::optional<Cap>& cap) {
  const std::vector<CriterionView> first{ViewAt(0, 0)};
  return CoverageMap(kSubject, {.cap = cap, .up_in_world = kUp, .threshold_px = 12}, first);
}

// New views are seen at once, within what the coarse grid can tell.
TEST(OpenDirections, FollowTheMapViewByView) {
  CoverageMap map = MapOf(kCap);
  OpenDirections open;
  open.Follow(map);
  for (int i = 1; i <= 40; ++i) {
    map.Add(ViewAt(-20 + i, 0.3 * i));
    open.Follow(map);
    EXPECT_LT(open.Gain((-20 + i) * M_PI / 180, 0.3 * i * M_PI / 180), 0.2) << "view " << i;
  }
  const double covered = open.CoveredSr() / (open.CoveredSr() + open.OpenSr());
  EXPECT_NEAR(covered, map.CoveredShare(), 0.01);
  EXPECT_NEAR(open.CoveredSr() + open.OpenSr(), kCap.SolidAngle(), 1e-9);
  // Far from all views a new one covers a whole disc; over the rim less.
  EXPECT_NEAR(open.Gain(-0.4, -0.2), 1, 0.05);
  EXPECT_LT(open.Gain(-0.5 * kCap.width, -0.2), 0.85);
}

// What is taken back is open again, though only by and by: the whole grid has been looked at after so many
// calls.
TEST(OpenDirections, NoticeReopenedOnesWithinSomeCalls) {
  CoverageMap map = MapOf(kCap);
  const CoverageMap before = map;
  map.Add(ViewAt(15, 5));
  OpenDirections open;
  open.Follow(map);
  EXPECT_LT(open.Gain(15 * M_PI / 180, 5 * M_PI / 180), 0.2);
  for (int i = 0; i < 40; ++i) open.Follow(before);
  EXPECT_NEAR(open.Gain(15 * M_PI / 180, 5 * M_PI / 180), 1, 0.05);
}

TEST(OpenDirections, GrowWithTheViewsWithoutACap) {
  CoverageMap map = MapOf(std::nullopt);
  OpenDirections open;
  open.Follow(map);
  const double at_first = open.CoveredSr() + open.OpenSr();
  EXPECT_FALSE(open.Wrapped(open.ColumnOf(1.2)));
  map.Add(ViewAt(70, 0));
  open.Follow(map);
  EXPECT_GT(open.CoveredSr() + open.OpenSr(), 2 * at_first);
  EXPECT_TRUE(open.Wrapped(open.ColumnOf(1.2)));
}

}  // namespace
}  // namespace ulf::test::open_directions_test
