// Tests: core/geometry/up_direction.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "core/geometry/angles.h"
#include "core/geometry/rigid3.h"
#include "core/geometry/up_direction.h"
#include "tests/support/floors.h"

namespace ulf::up_direction_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Up is z. `at` runs from 0 to 1 over the photographs.
struct Shape {
  std::string name;
  std::function<Rigid3(double at)> level_pose;
};

Vector3d At(double azimuth_deg, double elevation_deg) {
  const double azimuth = Radians(azimuth_deg), elevation = Radians(elevation_deg);
  return {std::cos(elevation) * std::sin(azimuth), -std::cos(elevation) * std::cos(azimuth),
          std::sin(elevation)};
}

Rigid3 LooksAtSubject(double azimuth_deg, double elevation_deg) {
  return LookAt(3 * At(azimuth_deg, elevation_deg), Vector3d::Zero(), Vector3d::UnitZ());
}

Rigid3 LooksAhead(const Vector3d& from, double azimuth_deg) {
  return LookAt(from, from + At(azimuth_deg, 0), Vector3d::UnitZ());
}

std::vector<Shape> Shapes() {
  return {
      {"a level ring", [](double at) { return LooksAtSubject(360 * at, 0); }},
      {"a ring that looks down", [](double at) { return LooksAtSubject(360 * at, 30); }},
      {"a ring that looks down steeply", [](double at) { return LooksAtSubject(360 * at, 60); }},
      {"a ring that looks up", [](double at) { return LooksAtSubject(360 * at, -30); }},
      {"an arc that looks down", [](double at) { return LooksAtSubject(-60 + 120 * at, 30); }},
      {"a cap that looks down",
       [](double at) { return LooksAtSubject(70 * std::sin(20 * at), 20 + 20 * std::sin(33 * at)); }},
      {"a grid that faces a wall",
       [](double at) {
         return LooksAhead({std::sin(20 * at), 0, std::sin(33 * at)}, 180);
       }},
      {"a walk past things",
       [](double at) {
         return LooksAhead({0, 5 * at, 1.6}, 180 + 25 * std::sin(9 * at));
       }},
      {"a panorama",
       [](double at) {
         return LooksAhead({0, 0, 1.6}, 360 * at);
       }},
  };
}

// Photographs of a shape, held with a tilt of this standard deviation, of which some are turned: by 90
// degrees to either side, or by 180.
std::vector<Matrix3d> Photographs(const Shape& shape, int count, int turned, double tilt_deg, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> tilt(0, Radians(tilt_deg));
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::shuffle(order, random);
  std::vector<Matrix3d> rotations;
  for (int i = 0; i < count; ++i) {
    constexpr double kTurns_deg[] = {90, -90, 180};
    const int rank = order[static_cast<std::size_t>(i)];
    const double roll = (rank < turned ? Radians(kTurns_deg[rank % 3]) : 0) + tilt(random);
    const Matrix3d level = shape.level_pose(i / static_cast<double>(count)).RotationMatrix();
    rotations.push_back(
        (Eigen::AngleAxisd(roll, Vector3d::UnitZ()) * Eigen::AngleAxisd(tilt(random), Vector3d::UnitX()) *
         Eigen::AngleAxisd(tilt(random), Vector3d::UnitY()))
            .toRotationMatrix() *
        level);
  }
  return rotations;
}

double OffDeg(const std::vector<Matrix3d>& rotations) {
  return Degrees(AngleBetween(UpOfCameras(rotations), Vector3d::UnitZ()));
}

class UpDirection : public testing::TestWithParam<int> {};

TEST_P(UpDirection, StaysThoughPhotographsAreTurned) {
  const int turned = GetParam();
  for (const Shape& shape : Shapes()) {
    EXPECT_LT(OffDeg(Photographs(shape, 12, turned, 0, 1)), 0.2) << shape.name << ", held exactly";
    for (const unsigned seed : {1u, 2u, 3u}) {
      EXPECT_LT(OffDeg(Photographs(shape, 12, turned, 1, seed)), 2) << shape.name << ", seed " << seed;
      EXPECT_LT(OffDeg(Photographs(shape, 60, 5 * turned, 3, seed)), 2)
          << shape.name << ", 60 photographs, seed " << seed;
    }
  }
}

// Narrow arcs leave the pitch to the level axes alone, which tell it no better than their tilts allow.
TEST(UpOfCameras, NarrowArcsAreOffByTheirTiltsAlone) {
  constexpr double kWidth_deg = 20, kTilt_deg = 1.5;
  constexpr int kSeeds = 25;
  for (const double elevation_deg : {15.0, 30.0, 45.0}) {
    const Shape arc{"a narrow arc",
                    [=](double at) { return LooksAtSubject(kWidth_deg * (at - 0.5), elevation_deg); }};
    EXPECT_LT(OffDeg(Photographs(arc, 12, 3, 0, 1)), 1.2) << elevation_deg << " degrees, held exactly";
    for (const int count : {60, 200}) {
      const double spread = Radians(kWidth_deg) / std::sqrt(12);
      const double known_to_deg = kTilt_deg / (spread * std::sqrt(count));
      double squares = 0;
      for (unsigned seed = 1; seed <= kSeeds; ++seed)
        squares += std::pow(OffDeg(Photographs(arc, count, count / 4, kTilt_deg, seed)), 2);
      EXPECT_LT(std::sqrt(squares / kSeeds), 1.3 * known_to_deg)
          << count << " photographs from " << elevation_deg << " degrees above";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfTwelve, UpDirection, testing::Range(0, 8));

TEST(UpOfCameras, IsTheSameInAnyWorld) {
  const Matrix3d turned_from_world =
      Eigen::AngleAxisd(2.1, Vector3d(0.3, -0.8, 0.5).normalized()).toRotationMatrix();
  for (const Shape& shape : Shapes()) {
    std::vector<Matrix3d> rotations = Photographs(shape, 12, 3, 1, 1);
    const Vector3d up = UpOfCameras(rotations);
    for (Matrix3d& rotation : rotations) rotation *= turned_from_world.transpose();
    EXPECT_LT((UpOfCameras(rotations) - turned_from_world * up).norm(), 1e-6) << shape.name;
  }
}

TEST(UpOfCameras, IsTheAxisOfARingOnItsSide) {
  for (const double turn_deg : {90.0, -90.0}) {
    std::vector<Matrix3d> rotations;
    for (int i = 0; i < 24; ++i)
      rotations.push_back(Eigen::AngleAxisd(Radians(turn_deg), Vector3d::UnitZ()) *
                          LooksAtSubject(15 * i, 20).RotationMatrix());
    EXPECT_LT(OffDeg(rotations), 0.1) << "all photographs turned by " << turn_deg;
  }
}

TEST(UpOfCameras, IsTheCamerasOwnOfFewPhotographs) {
  EXPECT_EQ(UpOfCameras({}), Vector3d(0, -1, 0));
  for (const int count : {1, 2, 3}) {
    std::vector<Matrix3d> rotations;
    for (int i = 0; i < count; ++i) rotations.push_back(LooksAhead(Vector3d::Zero(), 5 * i).RotationMatrix());
    EXPECT_LT(OffDeg(rotations), 0.1) << count << " photographs that look ahead";
  }
  // One alone does not tell that it looks down.
  const std::vector<Matrix3d> down{LooksAtSubject(0, 30).RotationMatrix()};
  EXPECT_NEAR(OffDeg(down), 30, 1e-6);
}

}  // namespace
}  // namespace ulf::up_direction_test
