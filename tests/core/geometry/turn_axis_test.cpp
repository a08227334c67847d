// Tests: core/geometry/turn_axis.
#include <gtest/gtest.h>

#include <random>

#include "core/geometry/turn_axis.h"
#include "tests/support/floors.h"

namespace ulf::turn_axis_test {
namespace {

using Eigen::Vector3d;

// A camera that stands at each of these heights for a turn of a table whose axis leans and stands off the
// board's middle; poses as a board gives them, with noise.
std::vector<Rigid3> PosesAround(const TurnAxis& axis, const std::vector<double>& elevations_deg,
                                int views_each, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto off = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  std::vector<Rigid3> poses;
  for (const double elevation_deg : elevations_deg) {
    const double elevation = Radians(elevation_deg);
    const Rigid3 stand =
        LookAt(axis.point_in_world + 0.8 * Vector3d(std::cos(elevation), 0, -std::sin(elevation)),
               axis.point_in_world, -Vector3d::UnitZ());
    for (int i = 0; i < views_each; ++i) {
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(2 * M_PI * i / views_each, axis.direction_in_world));
      const Rigid3 turned{turn, axis.point_in_world - turn * axis.point_in_world};
      Rigid3 pose = stand * turned;
      const Vector3d tilt = noise * off();
      if (tilt.norm() > 0) pose.rotation = Eigen::AngleAxisd(tilt.norm(), tilt.normalized()) * pose.rotation;
      pose.translation += 0.8 * noise * off();
      poses.push_back(pose);
    }
  }
  return poses;
}

TurnAxis LeaningAxis() { return {Vector3d(0.12, 0.15, 0), Vector3d(0.03, -0.05, -1).normalized()}; }

TEST(TurnAxis, IsFoundThroughSeveralStandsAndNoise) {
  for (const double noise : {0.0, 0.001, 0.003})
    for (const unsigned seed : {1u, 2u, 3u}) {
      const TurnAxis truth = LeaningAxis();
      const auto poses = PosesAround(truth, {20, 30, 40}, 30, noise, seed);
      const auto axis = FitTurnAxis(poses);
      ASSERT_TRUE(axis) << noise << ", seed " << seed;
      EXPECT_GT(std::abs(axis->direction_in_world.dot(truth.direction_in_world)), std::cos(1e-6 + noise))
          << noise << ", seed " << seed;
      const Vector3d between = axis->point_in_world - truth.point_in_world;
      EXPECT_LT(between.cross(truth.direction_in_world).norm(), 1e-9 + noise) << noise << ", seed " << seed;
    }
}

TEST(TurnAxis, StandsAreToldApart) {
  const auto poses = PosesAround(LeaningAxis(), {20, 24, 40}, 30, 0.001, 5);
  const auto axis = FitTurnAxis(poses);
  ASSERT_TRUE(axis);
  const std::vector<int> stands = StandsOf(*axis, poses);
  for (int i = 0; i < 90; ++i) EXPECT_EQ(stands[static_cast<std::size_t>(i)], i / 30) << i;
}

// A camera that is carried about things that stand still, up and down and in and out, has no such axis.
TEST(TurnAxis, ACarriedCameraHasNone) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<Rigid3> poses;
  Vector3d place(0.8, 0, -0.4);
  for (int i = 0; i < 60; ++i) {
    place += 0.12 * Vector3d(any(random), any(random), any(random));
    poses.push_back(LookAt(place, {0.1 * any(random), 0.1 * any(random), 0}, -Vector3d::UnitZ()));
  }
  EXPECT_FALSE(FitTurnAxis(poses));
  // Neither has one that stands before things that stand.
  EXPECT_FALSE(FitTurnAxis(std::vector<Rigid3>(40, poses.front())));
  EXPECT_FALSE(FitTurnAxis({}));
}

}  // namespace
}  // namespace ulf::turn_axis_test
