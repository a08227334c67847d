// Tests: core/geometry/trajectory.
#include "core/geometry/trajectory.h"

#include <gmock/gmock.h>

#include <fstream>

#include "core/base/error.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/scenes/geometry_scene.h"

namespace ulf::trajectory_test {
namespace {

using test::Draw;

std::vector<TimedPose> MakeTrajectory(int count, unsigned seed) {
  Draw draw(seed);
  std::vector<TimedPose> poses;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d center(std::sin(0.1 * i), 0.3 * std::cos(0.17 * i), 0.01 * i);
    poses.push_back({i / 30.0, LookAt(center, {0, 0, 5}, -Eigen::Vector3d::UnitY())});
  }
  return poses;
}

// The same cameras in a world that was turned, moved and scaled.
std::vector<TimedPose> InOtherWorld(const std::vector<TimedPose>& poses, const Similarity3& other_from_this) {
  std::vector<TimedPose> moved;
  for (const TimedPose& pose : poses) {
    const Eigen::Quaterniond rotation(
        Eigen::Matrix3d(pose.cam_from_world.RotationMatrix() * other_from_this.rotation.transpose()));
    const Eigen::Vector3d center = other_from_this * pose.cam_from_world.OriginInSource();
    moved.push_back({pose.time_s, {rotation, -(rotation * center)}});
  }
  return moved;
}

Similarity3 SomeSimilarity() {
  return {
      2.5, Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix(), {3, -1, 7}};
}

TEST(Trajectory, AlignmentIsExact) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    Draw draw(seed);
    std::vector<Eigen::Vector3d> source, target;
    for (int i = 0; i < 10; ++i) {
      source.emplace_back(draw.Normal(1), draw.Normal(1), draw.Normal(1));
      target.push_back(SomeSimilarity() * source.back());
    }
    const auto found = AlignPoints(source, target);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->scale, 2.5, 1e-12);
    EXPECT_LT((found->rotation - SomeSimilarity().rotation).norm(), 1e-12);
    EXPECT_LT((found->translation - SomeSimilarity().translation).norm(), 1e-11);
  }
}

TEST(Trajectory, AlignmentNeverMirrors) {
  std::vector<Eigen::Vector3d> source{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, target = source;
  for (Eigen::Vector3d& point : target) point.x() = -point.x();
  const auto found = AlignPoints(source, target);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->rotation.determinant(), 1, 1e-12);
}

TEST(Trajectory, AlignmentRefusesWhatFixesNothing) {
  const std::vector<Eigen::Vector3d> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}};
  EXPECT_FALSE(AlignPoints(line, line));
  EXPECT_FALSE(AlignPoints(std::vector<Eigen::Vector3d>(5, {1, 2, 3}), line));
  EXPECT_FALSE(AlignPoints({}, {}));
}

TEST(Trajectory, ErrorsVanishInAnotherWorld) {
  const auto truth = MakeTrajectory(100, 1);
  const auto error = CompareTrajectories(InOtherWorld(truth, SomeSimilarity()), truth, 0.01);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->matched, 100);
  EXPECT_LT(error->ate_rmse, 1e-10);
  EXPECT_LT(error->rpe_rmse, 1e-10);
  EXPECT_LT(error->rotation_rmse_deg, 1e-5);
  EXPECT_NEAR(error->scale, 1 / 2.5, 1e-12);
}

TEST(Trajectory, ErrorsAreThoseOfTheNoise) {
  const auto truth = MakeTrajectory(2000, 1);
  Draw draw(7);
  auto noisy = truth;
  for (TimedPose& pose : noisy) {
    const Eigen::Vector3d center = pose.cam_from_world.OriginInSource() +
                                   Eigen::Vector3d(draw.Normal(0.01), draw.Normal(0.01), draw.Normal(0.01));
    pose.cam_from_world.translation = -(pose.cam_from_world.rotation * center);
  }
  const auto error = CompareTrajectories(noisy, truth, 0.01);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->ate_rmse, 0.01 * std::sqrt(3.0), 0.001);
  EXPECT_NEAR(error->rpe_rmse, 0.01 * std::sqrt(6.0), 0.001);
}

// A world that turns by 1 degree a second too much, and whose truth comes in steps that do not divide the
// second.
TEST(Trajectory, RelativeErrorsAreTold) {
  auto truth = MakeTrajectory(300, 5);
  auto turning = truth;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i].time_s = turning[i].time_s = 0.4 * static_cast<double>(i);
    const Eigen::Quaterniond extra(Eigen::AngleAxisd(truth[i].time_s * M_PI / 180, Eigen::Vector3d::UnitY()));
    const Eigen::Vector3d center = truth[i].cam_from_world.OriginInSource();
    turning[i].cam_from_world.rotation = truth[i].cam_from_world.rotation * extra;
    turning[i].cam_from_world.translation = -(turning[i].cam_from_world.rotation * center);
  }
  const auto error = CompareTrajectories(turning, truth, 0.01);
  ASSERT_TRUE(error);
  EXPECT_GT(error->steps, 290);
  EXPECT_NEAR(error->rpe_rotation_rmse_deg, 1, 1e-6);
  EXPECT_LT(error->ate_max, 1e-9);
  EXPECT_FALSE(CompareTrajectories(turning, truth, 0.01, 0.1)->steps) << "no poses so near to each other";
}

TEST(Trajectory, TimesPairWithinTheTolerance) {
  const auto truth = MakeTrajectory(30, 1);
  auto late = truth;
  for (TimedPose& pose : late) pose.time_s += 0.01;
  EXPECT_EQ(CompareTrajectories(late, truth, 0.0166)->matched, 30);
  EXPECT_FALSE(CompareTrajectories(late, truth, 0.005));
}

TEST(Trajectory, FilesRoundTrip) {
  const test::ScratchFolder folder;
  const auto poses = MakeTrajectory(20, 3);
  WriteTum(folder / "poses.txt", poses);
  const auto read = ReadTum(folder / "poses.txt");
  ASSERT_EQ(read.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(read[i].time_s, poses[i].time_s, 1e-6);
    EXPECT_LT((read[i].cam_from_world.Matrix() - poses[i].cam_from_world.Matrix()).norm(), 1e-6);
  }
}

TEST(Trajectory, FailedWriteLeavesTheOldPoses) {
  const test::ScratchFolder folder;
  if (const auto problem = test::MountSmallDisk(folder.path(), 1 << 20)) GTEST_SKIP() << *problem;
  const auto poses = MakeTrajectory(20, 3);
  WriteTum(folder / "poses.txt", poses);
  test::FillDisk(folder / "filler");
  EXPECT_THROW(WriteTum(folder / "poses.txt", MakeTrajectory(400, 4)), DiskFullError);
  EXPECT_EQ(ReadTum(folder / "poses.txt").size(), poses.size());
  EXPECT_THROW(WriteTum(folder / "new.txt", poses), DiskFullError);
  EXPECT_FALSE(std::filesystem::exists(folder / "new.txt"));
}

TEST(Trajectory, BadFilesAreNamed) {
  const test::ScratchFolder folder;
  const auto message = [](const std::filesystem::path& path) -> std::string {
    try {
      ReadTum(path);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(message(folder / "missing.txt"), testing::HasSubstr("missing.txt"));
  std::ofstream(folder / "short.txt") << "# comment\n\n0 1 2 3 0 0 0\n";
  EXPECT_THAT(message(folder / "short.txt"), testing::HasSubstr("short.txt:3"));
  std::ofstream(folder / "zero.txt") << "0 1 2 3 0 0 0 0\n";
  EXPECT_THAT(message(folder / "zero.txt"), testing::HasSubstr("quaternion"));
  std::ofstream(folder / "nan.txt") << "0 nan 2 3 0 0 0 1\n";
  EXPECT_THAT(message(folder / "nan.txt"), testing::HasSubstr("nan.txt:1"));
  EXPECT_THROW(WriteTum(folder / "no" / "such" / "folder.txt", {}), Error);
}

}  // namespace
}  // namespace ulf::trajectory_test
