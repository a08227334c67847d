// Tests: tracking/features/succession.
//
// Frames of a hand at several rates, and photographs of the same room in any order.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "tests/tracking/scenes/textured_room.h"
#include "tracking/features/succession.h"

namespace ulf::succession_test {
namespace {

using test::Furniture;
using test::TexturedRoom;
using tracking::Succession;
using tracking::SuccessionFound;

const CameraModel kCamera = CameraModel::Pinhole(480, 360, 390);

SuccessionFound FoundIn(const TexturedRoom& room, const std::vector<Rigid3>& poses) {
  Succession succession;
  for (std::size_t i = 0; i < poses.size(); ++i) succession.Add(room.Take(poses[i], i, kCamera).image.pixels);
  return succession.found();
}

TEST(Succession, FramesOfAHandAreNear) {
  for (const unsigned seed : {1U, 2U, 3U})
    for (const int every : {1, 5, 10}) {  // 30, 6 and 3 frames a second
      std::vector<Rigid3> poses;
      for (int i = 0; i < 20; ++i) poses.push_back(TexturedRoom::HandAt(i * every));
      const SuccessionFound found = FoundIn(TexturedRoom({.seed = seed}), poses);
      EXPECT_EQ(found.near + found.apart, 19);
      EXPECT_LE(found.apart, every == 10 ? 4 : 1) << "seed " << seed << ", every " << every;
    }
}

TEST(Succession, PhotographsInAnyOrderAreApart) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::vector<Rigid3> around, in_room;
    for (int i = 0; i < 20; ++i) {
      const double angle = 0.07 * (i - 9.5);
      around.push_back(LookAt({2.4 * std::sin(angle), 0.3 * std::sin(3.0 * i), 2.4 - 2.4 * std::cos(angle)},
                              {0.4 * std::sin(5.0 * i), 0.3 * std::cos(4.0 * i), 2.4},
                              -Eigen::Vector3d::UnitY()));
      in_room.push_back(TexturedRoom::RoundAt(18 * i));
    }
    std::mt19937 random(seed);
    std::shuffle(around.begin(), around.end(), random);
    std::shuffle(in_room.begin(), in_room.end(), random);
    const SuccessionFound wall = FoundIn(TexturedRoom({.seed = seed}), around);
    EXPECT_GT(wall.apart, 2 * wall.near) << "seed " << seed;
    const SuccessionFound round =
        FoundIn(TexturedRoom({.furniture = Furniture::kRound, .seed = seed}), in_room);
    EXPECT_GT(round.apart, 2 * round.near) << "seed " << seed;
  }
}

TEST(Succession, PicturesWithoutCornersSayNothing) {
  Succession succession;
  for (int i = 0; i < 5; ++i) succession.Add(cv::Mat(360, 480, CV_8UC1, cv::Scalar(20 * i)));
  EXPECT_EQ(succession.found().near + succession.found().apart, 0);
}

TEST(Succession, AnotherSizeIsApart) {
  const TexturedRoom room({});
  Succession succession;
  succession.Add(room.Take(TexturedRoom::HandAt(0), 0, kCamera).image.pixels);
  succession.Add(room.Take(TexturedRoom::HandAt(1), 1, kCamera).image.pixels.t());
  EXPECT_EQ(succession.found().apart, 1);
}

}  // namespace
}  // namespace ulf::succession_test
