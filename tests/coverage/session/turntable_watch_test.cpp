// Tests: coverage/session/turntable_watch, coverage/session/capture_subject.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "coverage/session/capture_subject.h"
#include "coverage/session/turntable_watch.h"
#include "tests/support/floors.h"

namespace ulf::turntable_watch_test {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing::IsEmpty;

// The board's middle turns about itself; the camera stands at this elevation.
Rigid3 PoseAt(double turn_deg, double elevation_deg) {
  const Vector3d middle(0.1, 0.1, 0);
  const double azimuth = Radians(turn_deg), elevation = Radians(elevation_deg);
  return LookAt(middle + 0.8 * Vector3d(std::cos(elevation) * std::cos(azimuth),
                                        std::cos(elevation) * std::sin(azimuth), -std::sin(elevation)),
                middle, -Vector3d::UnitZ());
}

// What is said until `until_s`, ten frames a second.
template <typename PoseOf>
std::vector<std::string> SaidBy(TurntableWatch& watch, double from_s, double until_s, const PoseOf& pose_of) {
  std::vector<std::string> said;
  for (double t = from_s; t < until_s; t += 0.1)
    if (const std::string words = watch.Update(t, pose_of(t)); !words.empty()) said.push_back(words);
  return said;
}

TEST(TurntableWatch, SaysNothingWhileAllIsWell) {
  TurntableWatch watch("charuco:5x5:54:40:DICT_4X4_50", FrameSource::kCamera);
  EXPECT_THAT(SaidBy(watch, 0, 25, [](double t) { return std::optional(PoseAt(24 * t, 30)); }), IsEmpty());
}

TEST(TurntableWatch, SaysOnceThatTheBoardIsNotSeen) {
  TurntableWatch watch("charuco:5x5:54:40:DICT_4X4_50", FrameSource::kCamera);
  const auto said = SaidBy(watch, 0, 10, [](double) { return std::optional<Rigid3>(); });
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0], AllOf(HasSubstr("charuco:5x5:54:40:DICT_4X4_50 is not seen"), HasSubstr("aim at it")));
  EXPECT_THAT(SaidBy(watch, 10, 11, [](double t) { return std::optional(PoseAt(24 * t, 30)); }), IsEmpty());
  EXPECT_EQ(SaidBy(watch, 11, 20, [](double) { return std::optional<Rigid3>(); }).size(), 1u);
}

TEST(TurntableWatch, SaysThatNothingTurns) {
  TurntableWatch watch("charuco:5x5:54:40:DICT_4X4_50", FrameSource::kCamera);
  const auto said = SaidBy(watch, 0, 20, [](double) { return std::optional(PoseAt(10, 30)); });
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0], AllOf(HasSubstr("does not turn"), HasSubstr("start the turntable")));
}

TEST(TurntableWatch, SaysThatTheCameraWasMoved) {
  TurntableWatch watch("charuco:5x5:54:40:DICT_4X4_50", FrameSource::kCamera);
  const auto pose = [](double t) {
    return std::optional(PoseAt(24 * t, t < 15 ? 30 : t < 16 ? 30 + 8 * (t - 15) : 38));
  };
  EXPECT_THAT(SaidBy(watch, 0, 15, pose), IsEmpty());
  const auto said = SaidBy(watch, 15, 40, pose);
  ASSERT_FALSE(said.empty());
  EXPECT_LE(said.size(), 3u) << "while it is raised, and where it comes to rest";
  EXPECT_THAT(said[0], AllOf(HasSubstr("camera has been moved"), HasSubstr("a whole turn")));
}

TEST(TurntableWatch, OneWrongPoseIsNoMove) {
  TurntableWatch watch("charuco:5x5:54:40:DICT_4X4_50", FrameSource::kCamera);
  EXPECT_THAT(SaidBy(watch, 0, 25,
                     [](double t) {
                       const bool wrong = std::abs(t - 16) < 0.15;
                       return std::optional(PoseAt(24 * t, wrong ? 40 : 30));
                     }),
              IsEmpty());
}

// Where the optical axis passes nearest to what stands upright on the board.
TEST(DepthOfUpright, IsThatOfWhatStandsOnTheBoard) {
  const Vector3d foot(0.1, 0.1, 0);
  for (const double height : {0.0, 0.05, 0.2}) {
    const Vector3d eye(0.7, 0.2, -0.5), target = foot - height * Vector3d::UnitZ();
    const auto depth = DepthOfUpright(foot, LookAt(eye, target, -Vector3d::UnitZ()));
    ASSERT_TRUE(depth) << height;
    EXPECT_NEAR(*depth, (target - eye).norm(), 1e-9) << height;
  }
  EXPECT_FALSE(DepthOfUpright(foot, LookAt({0.1, 0.1, -1}, foot, Vector3d::UnitX()))) << "from right above";
  EXPECT_FALSE(DepthOfUpright(foot, LookAt({0.7, 0.2, -0.5}, {1.4, 0.3, -0.6}, -Vector3d::UnitZ())))
      << "looking away";
}

}  // namespace
}  // namespace ulf::turntable_watch_test
