// Tests: core/geometry/triangulation, tracking/estimation/absolute_pose, tracking/estimation/opengv_bridge,
// tracking/estimation/relative_pose, tracking/estimation/sampling.
#include <gtest/gtest.h>

#include <set>

#include "core/geometry/triangulation.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tracking/estimation/opengv_bridge.h"
#include "tracking/estimation/sampling.h"

namespace ulf::geometry_test {
namespace {

using test::DegreesBetween;
using test::Draw;
using test::MakeAbsoluteScene;
using test::MakeRelativeScene;
using test::Shape;

TEST(OpenGvBridge, P3pReturnsCamFromWorld) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto scene = MakeAbsoluteScene(3, 0, 0, seed);
    std::vector<Eigen::Vector3d> points, rays;
    for (const auto& seen : scene.matches) {
      points.push_back(seen.point_in_world);
      rays.push_back(*test::SceneCamera().RayFromImg(seen.img));
    }
    double nearest = 1e9;
    for (const Rigid3& pose : SolveP3p(points, rays))
      nearest = std::min(nearest, (pose.translation - scene.cam_from_world.translation).norm() +
                                      DegreesBetween(pose.rotation, scene.cam_from_world.rotation));
    EXPECT_LT(nearest, 1e-4) << "seed " << seed;
  }
}

TEST(OpenGvBridge, FivePointEssentialTakesFirstToSecond) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto scene = MakeRelativeScene(30, Shape::kDeep, 0.6, 0, 0, seed);
    std::vector<Eigen::Vector3d> first, second;
    for (int i = 0; i < 5; ++i) {
      first.push_back(scene.pairs[static_cast<std::size_t>(i)].first);
      second.push_back(scene.pairs[static_cast<std::size_t>(i)].second);
    }
    double least = 1e9;  // of the worst pair, over the solutions: one must explain pairs it was not made from
    for (const auto& essential : SolveFivePoint(first, second)) {
      double worst = 0;
      for (const RayPair& pair : scene.pairs) worst = std::max(worst, EpipolarError(essential, pair));
      least = std::min(least, worst);
    }
    EXPECT_LT(least, 1e-6) << "seed " << seed;
  }
}

TEST(Sampling, TheSameSeedGivesTheSameModel) {
  const auto scene = MakeAbsoluteScene(200, 1, 0.6, 5);
  const auto first = AbsolutePose(test::SceneCamera(), scene.matches, {.seed = 9});
  const auto second = AbsolutePose(test::SceneCamera(), scene.matches, {.seed = 9});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->inliers, second->inliers);
  EXPECT_EQ(first->cam_from_world.Matrix(), second->cam_from_world.Matrix());
}

TEST(Sampling, DrawsAreDistinct) {
  std::mt19937 random(4);
  std::vector<int> sample(5);
  for (int round = 0; round < 200; ++round) {
    internal::DrawSample(random, 6, sample);
    EXPECT_EQ(std::set<int>(sample.begin(), sample.end()).size(), 5u);
  }
}

TEST(AbsolutePoseTest, IsFoundThroughNoiseAndOutliers) {
  for (const double noise_px : {0.0, 0.5, 1.0, 2.0})
    for (const double outliers : {0.0, 0.5, 0.75})
      for (const unsigned seed : {1u, 2u, 3u, 4u}) {
        const auto scene = MakeAbsoluteScene(300, noise_px, outliers, seed);
        const auto found = AbsolutePose(test::SceneCamera(), scene.matches,
                                        {.threshold_px = 4, .max_iterations = 2000, .seed = seed});
        ASSERT_TRUE(found) << noise_px << " px, outliers " << outliers << ", seed " << seed;
        EXPECT_LT(DegreesBetween(found->cam_from_world.rotation, scene.cam_from_world.rotation),
                  1e-4 + 0.18 * noise_px)
            << noise_px << " px, outliers " << outliers << ", seed " << seed;
      }
}

TEST(AbsolutePoseTest, RefusesPureChance) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u}) {
    const auto scene = MakeAbsoluteScene(100, 1, 1.0, seed);
    EXPECT_FALSE(AbsolutePose(test::SceneCamera(), scene.matches, {.min_inliers = 12, .seed = seed}))
        << "seed " << seed;
  }
}

TEST(AbsolutePoseTest, TooFewPointsIsNoAnswer) {
  const auto scene = MakeAbsoluteScene(3, 0, 0, 1);
  EXPECT_FALSE(AbsolutePose(test::SceneCamera(), scene.matches));
  EXPECT_FALSE(RefinePose(test::SceneCamera(), scene.matches, scene.cam_from_world));
}

TEST(RefinePoseTest, RecoversTruthFromAPerturbedStart) {
  for (const double noise_px : {0.0, 0.5, 1.0})
    for (const unsigned seed : {1u, 2u, 3u}) {
      const auto scene = MakeAbsoluteScene(150, noise_px, 0.2, seed);
      Draw draw(seed + 100);
      Eigen::Matrix<double, 6, 1> twist;
      for (int i = 0; i < 6; ++i) twist(i) = draw.Uniform(-0.03, 0.03);
      const auto refined = RefinePose(test::SceneCamera(), scene.matches,
                                      Perturbed(scene.cam_from_world, twist), {.rounds = 5});
      ASSERT_TRUE(refined) << noise_px << " px, seed " << seed;
      const double center_error =
          (refined->cam_from_world.OriginInSource() - scene.cam_from_world.OriginInSource()).norm();
      EXPECT_LT(center_error, 1e-6 + 0.03 * noise_px) << noise_px << " px, seed " << seed;
      if (noise_px > 0) {
        EXPECT_LT(center_error, 5 * refined->center_sigma) << noise_px << " px, seed " << seed;
      }
    }
}

TEST(RefinePoseTest, PerturbationIsATwistOnTheLeft) {
  Draw draw(8);
  const Rigid3 pose = test::RandomPose(draw, 2, 2);
  Eigen::Matrix<double, 6, 1> twist;
  twist << 1e-6, -2e-6, 3e-6, 4e-6, -5e-6, 6e-6;
  const Eigen::Vector3d point(0.3, -0.7, 2.0), before = pose * point, after = Perturbed(pose, twist) * point;
  const Eigen::Vector3d expected = twist.head<3>().cross(before) + twist.tail<3>();
  EXPECT_LT((after - before - expected).norm(), 1e-10);
}

TEST(TriangulationTest, IsExactWithoutNoise) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Draw draw(seed);
    const Rigid3 first = test::RandomPose(draw, 0.4, 0.5), second = test::RandomPose(draw, 0.4, 0.5);
    const Eigen::Vector3d point(draw.Uniform(-1, 1), draw.Uniform(-1, 1), draw.Uniform(3, 8));
    const Eigen::Vector3d ray1 = (first * point).normalized(), ray2 = (second * point).normalized();
    const auto made = TriangulatePoint(first, ray1, second, ray2);
    ASSERT_TRUE(made) << "seed " << seed;
    EXPECT_LT((*made - point).norm(), 1e-8) << "seed " << seed;
    const std::vector<RayObservation> observations{{first, ray1}, {second, ray2}};
    const auto many = TriangulatePoint(observations);
    ASSERT_TRUE(many) << "seed " << seed;
    EXPECT_LT((*many - point).norm(), 1e-6) << "seed " << seed;
  }
}

TEST(TriangulationTest, RefusesWhatLiesBehindOrNowhere) {
  const Rigid3 second{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
  EXPECT_FALSE(TriangulatePoint(Rigid3{}, Eigen::Vector3d::UnitZ(), second, Eigen::Vector3d::UnitZ()));
  // Rays that diverge meet behind the cameras.
  EXPECT_FALSE(TriangulatePoint(Rigid3{}, Eigen::Vector3d(-0.1, 0, 1).normalized(), second,
                                Eigen::Vector3d(0.1, 0, 1).normalized()));
  EXPECT_FALSE(TriangulatePoint(std::vector<RayObservation>{{Rigid3{}, Eigen::Vector3d::UnitZ()}}));
}

TEST(TriangulationTest, ParallaxIsTheAngleAtThePoint) {
  EXPECT_NEAR(ParallaxAngle({0, 0, 1}, {0, 0, 0}, {1, 0, 1}), M_PI / 2, 1e-12);
  EXPECT_NEAR(ParallaxAngle({0, 0, 5}, {0, 0, 0}, {0, 0, 0}), 0, 1e-12);
}

TEST(RelativePoseTest, IsFoundThroughNoiseAndOutliers) {
  for (const double noise_px : {0.0, 0.3, 0.7})
    for (const double outliers : {0.0, 0.3, 0.5})
      for (const unsigned seed : {1u, 2u, 3u, 4u}) {
        const auto scene = MakeRelativeScene(400, Shape::kDeep, 0.8, noise_px, outliers, seed);
        const auto found = RelativePose(scene.pairs, {.focal_px = 525, .seed = seed});
        ASSERT_EQ(found.outcome, RelativePoseOutcome::kFound)
            << Name(found.outcome) << ", " << noise_px << " px, outliers " << outliers << ", seed " << seed;
        EXPECT_EQ(found.model, RelativePoseModel::kEssential) << noise_px << " px, seed " << seed;
        EXPECT_LT(DegreesBetween(found.second_from_first.rotation, scene.second_from_first.rotation),
                  1e-3 + 0.6 * noise_px)
            << noise_px << " px, outliers " << outliers << ", seed " << seed;
        EXPECT_LT(DegreesBetween(found.second_from_first.translation, scene.second_from_first.translation),
                  1e-2 + 4 * noise_px)
            << noise_px << " px, outliers " << outliers << ", seed " << seed;
      }
}

// A plane has two motions that explain it; whoever answers must answer right, and saying "ambiguous" is
// right, too.
TEST(RelativePoseTest, FlatSceneIsNeverAnsweredWrong) {
  int answered = 0;
  for (const double noise_px : {0.0, 0.3})
    for (unsigned seed = 1; seed <= 8; ++seed) {
      const auto scene = MakeRelativeScene(400, Shape::kFlat, 1.2, noise_px, 0.1, seed);
      const auto found = RelativePose(scene.pairs, {.focal_px = 525, .seed = seed});
      EXPECT_TRUE(found.outcome == RelativePoseOutcome::kFound ||
                  found.outcome == RelativePoseOutcome::kAmbiguous)
          << Name(found.outcome) << ", " << noise_px << " px, seed " << seed;
      EXPECT_EQ(found.model, RelativePoseModel::kHomography) << noise_px << " px, seed " << seed;
      EXPECT_GT(found.evidence.by_homography, 0.85 * found.evidence.by_essential);
      // The same eyes on something deep: what the choice hangs on says the other thing.
      const auto deep = MakeRelativeScene(400, Shape::kDeep, 1.2, noise_px, 0.1, seed);
      const auto other = RelativePose(deep.pairs, {.focal_px = 525, .seed = seed});
      EXPECT_EQ(other.model, RelativePoseModel::kEssential) << noise_px << " px, seed " << seed;
      EXPECT_LT(other.evidence.by_homography, 0.85 * other.evidence.by_essential);
      EXPECT_LT(other.evidence.by_rotation, other.evidence.by_essential);
      EXPECT_EQ(other.evidence.matches, 400);
      EXPECT_GT(other.evidence.runner_up, other.evidence.runner_up_needed);
      if (found.outcome != RelativePoseOutcome::kFound) continue;
      ++answered;
      EXPECT_LT(DegreesBetween(found.second_from_first.rotation, scene.second_from_first.rotation), 1)
          << noise_px << " px, seed " << seed;
      EXPECT_LT(DegreesBetween(found.second_from_first.translation, scene.second_from_first.translation), 4)
          << noise_px << " px, seed " << seed;
    }
  EXPECT_GE(answered, 6);  // of 16
  EXPECT_LE(answered, 15) << "some have two motions";
}

TEST(RelativePoseTest, RotationAloneIsRefused) {
  for (const double noise_px : {0.0, 0.3, 0.7})
    for (const double outliers : {0.0, 0.3})
      for (unsigned seed = 1; seed <= 6; ++seed)
        for (const Shape shape : {Shape::kDeep, Shape::kFlat}) {
          const auto scene = MakeRelativeScene(400, shape, 1e-9, noise_px, outliers, seed);
          const auto found = RelativePose(scene.pairs, {.focal_px = 525, .seed = seed});
          EXPECT_EQ(found.outcome, RelativePoseOutcome::kRotationOnly)
              << Name(found.outcome) << ", " << noise_px << " px, outliers " << outliers << ", seed " << seed;
        }
}

TEST(RelativePoseTest, ChanceAndTooLittleAreRefused) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const auto chance = MakeRelativeScene(300, Shape::kDeep, 0.5, 0, 1.0, seed);
    EXPECT_NE(RelativePose(chance.pairs, {.focal_px = 525, .seed = seed}).outcome,
              RelativePoseOutcome::kFound)
        << "seed " << seed;
    const auto few = MakeRelativeScene(10, Shape::kDeep, 0.5, 0, 0, seed);
    EXPECT_EQ(RelativePose(few.pairs, {.focal_px = 525, .seed = seed}).outcome,
              RelativePoseOutcome::kTooFewMatches);
  }
}

}  // namespace
}  // namespace ulf::geometry_test
