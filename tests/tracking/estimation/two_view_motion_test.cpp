// Tests: tracking/estimation/two_view_motion.
#include "tracking/estimation/two_view_motion.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"

namespace ulf::two_view_motion_test {
namespace {

using test::DegreesBetween;

struct Case {
  test::RelativeScene scene;
  std::vector<int> all;
};

Case MakeCase(double noise_px, unsigned seed) {
  Case made{test::MakeRelativeScene(120, test::Shape::kDeep, 0.4, noise_px, 0, seed), {}};
  made.all.resize(made.scene.pairs.size());
  std::iota(made.all.begin(), made.all.end(), 0);
  return made;
}

TEST(TwoViewMotion, AnEssentialMatrixGivesItsMotionBack) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const auto [scene, all] = MakeCase(0, seed);
    const Eigen::Matrix3d essential = EssentialFromPose(scene.second_from_first);
    for (const RayPair& pair : scene.pairs) EXPECT_LT(EpipolarError(essential, pair), 1e-6);
    const auto motion = BestMotion(essential, scene.pairs, all);
    ASSERT_TRUE(motion) << seed;
    EXPECT_LT(DegreesBetween(motion->second_from_first.rotation, scene.second_from_first.rotation), 1e-3);
    EXPECT_LT(DegreesBetween(motion->second_from_first.translation, scene.second_from_first.translation),
              1e-3);
  }
}

TEST(TwoViewMotion, RefiningReachesTheTruth) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const auto [scene, all] = MakeCase(0, seed);
    Rigid3 start = scene.second_from_first;
    start.rotation = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()) * start.rotation;
    start.translation = (start.translation.normalized() + Eigen::Vector3d(0.05, 0.05, 0)).normalized();
    const Motion refined = RefineMotion(Motion(start), scene.pairs, all, 1, 20);
    EXPECT_LT(DegreesBetween(refined.second_from_first.translation, scene.second_from_first.translation),
              0.01)
        << seed;
    EXPECT_LT(TruncatedCost(refined, scene.pairs, all, 1), 1e-12);
  }
}

TEST(TwoViewMotion, PointsBehindCountAsOutliers) {
  const auto [scene, all] = MakeCase(0.3, 4);
  const double gate = 3.0 / 525, noise = 1.0 / 525;
  const Motion truth(scene.second_from_first);
  Rigid3 backwards = scene.second_from_first;
  backwards.translation = -backwards.translation;
  const Motion reversed(backwards);
  EXPECT_NEAR(TruncatedCost(truth, scene.pairs, all, gate), TruncatedCost(reversed, scene.pairs, all, gate),
              1e-12)
      << "epipolar lines do not tell";
  EXPECT_GT(CostInFront(reversed, scene.pairs, gate, noise),
            10 * CostInFront(truth, scene.pairs, gate, noise));
}

}  // namespace
}  // namespace ulf::two_view_motion_test
