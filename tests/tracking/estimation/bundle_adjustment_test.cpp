// Tests: tracking/estimation/bundle_adjustment, tracking/estimation/bundle_uncertainty,
// tracking/estimation/free_intrinsics, tracking/estimation/residuals.
#include "tracking/estimation/bundle_adjustment.h"

#include <gtest/gtest.h>

#include "core/geometry/similarity3.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tracking/estimation/bundle_uncertainty.h"
#include "tracking/estimation/residuals.h"

namespace ulf::bundle_adjustment_test {
namespace {

using test::Draw;

struct Scene {
  BundleProblem truth;
  BundleProblem disturbed;
};

Scene MakeScene(double noise_px, double outliers, unsigned seed, const CameraModel& camera) {
  Draw draw(seed);
  Scene scene;
  for (int c = 0; c < 6; ++c) {
    const Eigen::Vector3d center(0.4 * c - 1, draw.Uniform(-0.3, 0.3), draw.Uniform(-0.3, 0.3));
    scene.truth.cam_from_world.push_back(LookAt(center, {0, 0, 4}, -Eigen::Vector3d::UnitY()));
    scene.truth.fixed.push_back(c < 2);
  }
  for (int p = 0; p < 150; ++p)
    scene.truth.points.emplace_back(draw.Uniform(-1.2, 1.2), draw.Uniform(-0.9, 0.9), draw.Uniform(3, 5.5));
  for (int c = 0; c < 6; ++c)
    for (int p = 0; p < 150; ++p) {
      auto img = camera.ImgFromCam(scene.truth.cam_from_world[static_cast<std::size_t>(c)] *
                                   scene.truth.points[static_cast<std::size_t>(p)]);
      if (!img || !camera.Contains(*img)) continue;
      *img += Eigen::Vector2d(draw.Normal(noise_px), draw.Normal(noise_px));
      if (draw.Uniform(0, 1) < outliers)
        *img += Eigen::Vector2d(draw.Uniform(10, 40), draw.Uniform(-40, -10));
      scene.truth.observations.push_back({c, p, *img, std::max(0.2, noise_px), false});
    }
  scene.disturbed = scene.truth;
  for (std::size_t c = 2; c < 6; ++c) {
    Eigen::Matrix<double, 6, 1> twist;
    for (int i = 0; i < 6; ++i) twist(i) = draw.Uniform(-0.02, 0.02);
    scene.disturbed.cam_from_world[c] = Perturbed(scene.disturbed.cam_from_world[c], twist);
  }
  for (Eigen::Vector3d& point : scene.disturbed.points) point += 0.05 * draw.Direction();
  return scene;
}

double CenterError(const BundleProblem& a, const BundleProblem& b) {
  double worst = 0;
  for (std::size_t c = 0; c < a.cam_from_world.size(); ++c)
    worst =
        std::max(worst, (a.cam_from_world[c].OriginInSource() - b.cam_from_world[c].OriginInSource()).norm());
  return worst;
}

// Every fifth point wanders, by the same in neighbouring views, as a patch over an edge in depth does: within
// its sigma, but far beyond the noise.
TEST(BundleAdjustment, DoubtsLargeResiduals) {
  const CameraModel camera = test::SceneCamera();
  double huber = 0, cauchy = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u}) {
    Scene scene = MakeScene(0.1, 0, seed, camera);
    for (BundleObservation& seen : scene.disturbed.observations) {
      seen.sigma_px = 1;
      if (seen.point % 5 == 0) seen.img += Eigen::Vector2d(0.3, -0.2) * seen.camera;
    }
    for (const bool doubting : {false, true}) {
      BundleProblem solved = scene.disturbed;
      ASSERT_TRUE(AdjustBundle(camera, solved, {.cauchy_scales = doubting ? 2.0 : 0.0}).usable);
      (doubting ? cauchy : huber) += CenterError(solved, scene.truth);
    }
  }
  EXPECT_LT(cauchy, 0.5 * huber);
}

// Sigmas are what may be feared; what is off by eight times what the errors really are is wrong all the same.
TEST(BundleAdjustment, RejectsByMeasuredNotStatedErrors) {
  const CameraModel camera = test::SceneCamera();
  double kept = 0, gated = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u}) {
    Scene scene = MakeScene(0.1, 0, seed, camera);
    const auto is_wrong = [](const BundleObservation& seen) { return seen.camera == seen.point % 12; };
    for (BundleObservation& seen : scene.disturbed.observations) {
      seen.sigma_px = 1;
      if (is_wrong(seen)) seen.img.x() += 1;
    }
    BundleProblem solved = scene.disturbed;
    ASSERT_TRUE(AdjustBundle(camera, solved, {.cauchy_scales = 2}).usable);
    kept += CenterError(solved, scene.truth);
    solved = scene.disturbed;
    ASSERT_TRUE(AdjustBundle(camera, solved, {.cauchy_scales = 2, .gate_scales = 4}).usable);
    gated += CenterError(solved, scene.truth);
    int found = 0, wrong = 0, lost = 0;
    for (const BundleObservation& seen : solved.observations) {
      wrong += is_wrong(seen);
      found += is_wrong(seen) && seen.outlier;
      lost += !is_wrong(seen) && seen.outlier;
    }
    EXPECT_GT(found, 0.9 * wrong) << "seed " << seed;
    EXPECT_LT(lost, 0.02 * static_cast<double>(solved.observations.size())) << "seed " << seed;
  }
  EXPECT_LT(gated, kept);
}

TEST(BundleAdjustment, RecoversTruth) {
  const CameraModel camera = test::SceneCamera();
  for (const double noise_px : {0.0, 0.5})
    for (const double outliers : {0.0, 0.05})
      for (const unsigned seed : {1u, 2u, 3u}) {
        Scene scene = MakeScene(noise_px, outliers, seed, camera);
        const BundleSummary summary =
            AdjustBundle(camera, scene.disturbed, {.robust_iterations = 20, .iterations = 20});
        ASSERT_TRUE(summary.usable) << summary.message;
        EXPECT_LT(summary.final_rms_sigmas, summary.initial_rms_sigmas);
        EXPECT_LT(CenterError(scene.disturbed, scene.truth), 1e-4 + 0.06 * noise_px)
            << noise_px << " px, outliers " << outliers << ", seed " << seed;
        if (outliers > 0) {
          int marked = 0;
          for (const BundleObservation& seen : scene.disturbed.observations) marked += seen.outlier;
          EXPECT_GT(marked, 0.7 * outliers * static_cast<double>(scene.disturbed.observations.size()));
        }
      }
}

// Cameras that turn while their rows are read, each with another velocity of which a guess is known.
TEST(BundleAdjustment, FindsRowVelocitiesWithThePoses) {
  const CameraModel camera = test::SceneCamera();
  constexpr double kReadout_s = 0.03;
  double ignored = 0, guessed = 0, found = 0, off = 0, off_before = 0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    Scene scene = MakeScene(0.1, 0, seed, camera);
    Draw draw(seed + 10);
    scene.disturbed.readout_s = kReadout_s;
    std::vector<Twist> twists(6);
    for (Twist& twist : twists) {
      for (int i = 0; i < 6; ++i) twist(i) = draw.Uniform(-1, 1);
      RowsMotion motion{twist, twist, Twist::Constant(0.2)};
      for (int i = 0; i < 6; ++i) motion.twist(i) += draw.Normal(0.1);
      motion.prior = motion.twist;
      scene.disturbed.rows.emplace_back(motion);
    }
    for (BundleObservation& seen : scene.disturbed.observations) {
      const auto c = static_cast<std::size_t>(seen.camera);
      const Eigen::Vector3d at_once =
          scene.truth.cam_from_world[c] * scene.truth.points[static_cast<std::size_t>(seen.point)];
      for (int i = 0; i < 6; ++i)
        if (const auto img = camera.ImgFromCam(
                PointAfter(twists[c], at_once, RowTime(kReadout_s, seen.img.y(), camera.height))))
          seen.img = *img + Eigen::Vector2d(draw.Normal(0.1), draw.Normal(0.1));
      seen.sigma_px = 0.2;
    }
    BundleProblem solved = scene.disturbed;
    ASSERT_TRUE(AdjustBundle(camera, solved, {.robust_iterations = 20, .iterations = 20}).usable);
    found += CenterError(solved, scene.truth);
    for (std::size_t c = 0; c < 6; ++c) {
      off += (solved.rows[c]->twist - twists[c]).head<3>().norm();
      off_before += (scene.disturbed.rows[c]->twist - twists[c]).head<3>().norm();
    }
    solved = scene.disturbed;
    for (auto& rows : solved.rows) rows->prior_sigma.setConstant(1e-6);
    AdjustBundle(camera, solved, {.robust_iterations = 20, .iterations = 20, .gate_sigmas = 1e3});
    guessed += CenterError(solved, scene.truth);
    solved = scene.disturbed;
    solved.rows.clear();
    AdjustBundle(camera, solved, {.robust_iterations = 20, .iterations = 20, .gate_sigmas = 1e3});
    ignored += CenterError(solved, scene.truth);
  }
  EXPECT_LT(found, 0.3 * guessed);
  EXPECT_LT(guessed, 0.5 * ignored);
  // A turn and a shift of the camera look alike over so little depth: together they are known
  // better than each.
  EXPECT_LT(off, 0.8 * off_before);
}

TEST(BundleAdjustment, FixedCamerasStay) {
  const CameraModel camera = test::SceneCamera();
  Scene scene = MakeScene(0.5, 0, 4, camera);
  AdjustBundle(camera, scene.disturbed);
  for (const std::size_t c : {0u, 1u})
    EXPECT_EQ(scene.disturbed.cam_from_world[c].Matrix(), scene.truth.cam_from_world[c].Matrix());
}

TEST(BundleAdjustment, WithOneFixedCameraTheScaleStays) {
  const CameraModel camera = test::SceneCamera();
  Scene scene = MakeScene(0.5, 0, 5, camera);
  scene.disturbed.fixed.assign(6, false);
  const auto extent = [](const BundleProblem& problem) {
    double farthest = 0;
    for (const Rigid3& pose : problem.cam_from_world)
      farthest =
          std::max(farthest, (pose.OriginInSource() - problem.cam_from_world[0].OriginInSource()).norm());
    return farthest;
  };
  const double before = extent(scene.disturbed);
  const Eigen::Matrix4d first = scene.disturbed.cam_from_world[0].Matrix();
  const BundleSummary summary = AdjustBundle(camera, scene.disturbed);
  ASSERT_TRUE(summary.usable);
  EXPECT_LT((scene.disturbed.cam_from_world[0].Matrix() - first).norm(), 1e-12);
  EXPECT_NEAR(extent(scene.disturbed), before, 0.01 * before);
}

// Moved, turned and scaled as a whole, with no camera fixed: known points bring everything back; without them
// nothing does.
TEST(BundleAdjustment, KnownPointsFixTheFrame) {
  const CameraModel camera = test::SceneCamera();
  for (const unsigned seed : {1u, 2u, 3u}) {
    Scene scene = MakeScene(0.2, 0, seed, camera);
    BundleProblem& moved = scene.disturbed;
    moved = scene.truth;
    moved.fixed.assign(moved.fixed.size(), false);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.6, 0, 0.8)));
    const Eigen::Vector3d shift(0.1, -0.05, 0.08);
    constexpr double kScale = 1.05;
    for (Rigid3& pose : moved.cam_from_world) {
      const Eigen::Vector3d center = kScale * (turn * pose.OriginInSource()) + shift;
      pose.rotation = pose.rotation * turn.conjugate();
      pose.translation = -(pose.rotation * center);
    }
    for (Eigen::Vector3d& point : moved.points) point = kScale * (turn * point) + shift;
    for (const bool known : {false, true}) {
      BundleProblem solved = moved;
      if (known) solved.known.assign(20, true);
      for (std::size_t p = 0; known && p < 20; ++p) solved.points[p] = scene.truth.points[p];
      // What is known is far from where it is seen at first: no outlier yet.
      ASSERT_TRUE(AdjustBundle(camera, solved, {.robust_iterations = 20, .huber_sigmas = 1e3}).usable);
      if (known) {
        EXPECT_LT(CenterError(solved, scene.truth), 0.01);
        EXPECT_EQ(solved.points[7], scene.truth.points[7]);
      } else {
        EXPECT_GT(CenterError(solved, scene.truth), 0.08);
      }
    }
  }
}

// Wrong all over the picture: the more of them there are, the more agrees with anything.
TEST(BundleAdjustment, RejectsAContradictedSolution) {
  const CameraModel camera = test::SceneCamera();
  for (const double wrong : {0.3, 0.7}) {
    Scene scene = MakeScene(0.5, 0, 6, camera);
    Draw draw(6);
    for (BundleObservation& seen : scene.disturbed.observations)
      if (draw.Uniform(0, 1) < wrong) seen.img = {draw.Uniform(0, 640), draw.Uniform(0, 480)};
    const Eigen::Matrix4d before = scene.disturbed.cam_from_world[3].Matrix();
    const BundleSummary summary =
        AdjustBundle(camera, scene.disturbed, {.robust_iterations = 30, .iterations = 30});
    EXPECT_EQ(summary.usable, wrong < 0.5) << wrong;
    EXPECT_EQ(scene.disturbed.cam_from_world[3].Matrix() == before, wrong > 0.5) << wrong;
    if (wrong > 0.5) {
      EXPECT_NE(summary.message.find("agree"), std::string::npos) << summary.message;
    } else {
      EXPECT_LT(CenterError(scene.disturbed, scene.truth), 0.1) << wrong;
    }
  }
}

// All agree but one view, whose observations are another scene's.
TEST(BundleAdjustment, NamesAContradictedView) {
  const CameraModel camera = test::SceneCamera();
  Scene scene = MakeScene(0.5, 0, 6, camera);
  BundleProblem right = scene.disturbed;
  EXPECT_GT(AdjustBundle(camera, right).least_kept, 0.8);
  Draw draw(6);
  for (BundleObservation& seen : scene.disturbed.observations)
    if (seen.camera == 3) seen.img = {draw.Uniform(0, camera.width), draw.Uniform(0, camera.height)};
  const BundleSummary summary = AdjustBundle(camera, scene.disturbed);
  ASSERT_TRUE(summary.usable) << summary.message;
  EXPECT_EQ(summary.least_kept_camera, 3);
  EXPECT_LT(summary.least_kept, 0.5);
}

TEST(BundleAdjustment, TellsWhetherItSettled) {
  const CameraModel camera = test::SceneCamera();
  for (const int iterations : {1, 40}) {
    Scene scene = MakeScene(0.5, 0, 7, camera);
    const BundleSummary summary =
        AdjustBundle(camera, scene.disturbed,
                     {.robust_iterations = iterations, .iterations = iterations, .gate_sigmas = 100});
    ASSERT_TRUE(summary.usable) << summary.message;
    EXPECT_EQ(summary.settled, iterations > 1);
  }
}

// Errors over many draws of the noise, of cameras that are held and of ones that only hold each other.
TEST(CenterSigmas, PredictTheErrors) {
  const CameraModel camera = test::SceneCamera();
  for (const bool held : {true, false}) {
    double squared = 0, predicted = 0;
    for (unsigned seed = 1; seed <= 30; ++seed) {
      Scene scene = MakeScene(0.5, 0, seed, camera);
      if (!held) scene.disturbed.fixed.assign(6, false);
      ASSERT_TRUE(AdjustBundle(camera, scene.disturbed, {.robust_iterations = 20, .gate_sigmas = 10}).usable);
      const std::vector<double> sigmas = CenterSigmas({camera}, scene.disturbed);
      ASSERT_EQ(sigmas.size(), 6u);
      std::vector<Eigen::Vector3d> found, truth;
      for (std::size_t c = 0; c < 6; ++c) {
        found.push_back(scene.disturbed.cam_from_world[c].OriginInSource());
        truth.push_back(scene.truth.cam_from_world[c].OriginInSource());
        predicted += sigmas[c] * sigmas[c];
        if (held && c < 2) {
          EXPECT_EQ(sigmas[c], 0);
        } else {
          EXPECT_GT(sigmas[c], 0);
        }
      }
      const Similarity3 fit = held ? Similarity3{} : *AlignPoints(found, truth);
      for (std::size_t c = 0; c < 6; ++c) squared += (fit * found[c] - truth[c]).squaredNorm();
    }
    EXPECT_NEAR(std::sqrt(squared / predicted), 1, 0.2) << (held ? "held" : "free");
  }
}

// Two parts that share one view and no point: how large one is beside the other nothing tells.
TEST(CenterSigmas, AreInfiniteWhereSomethingMovesFreely) {
  const CameraModel camera = test::SceneCamera();
  Scene scene = MakeScene(0.5, 0, 8, camera);
  BundleProblem& problem = scene.truth;
  problem.fixed.assign(6, false);
  for (const double sigma : CenterSigmas({camera}, problem)) EXPECT_LT(sigma, 0.1);
  // Points of the first half are seen by cameras 0 to 3, the others by 3 to 5: camera 3 is a hinge.
  std::erase_if(problem.observations, [](const BundleObservation& seen) {
    return seen.point < 75 ? seen.camera > 3 : seen.camera < 3;
  });
  for (const double sigma : CenterSigmas({camera}, problem)) EXPECT_TRUE(std::isinf(sigma)) << sigma;
  std::erase_if(problem.observations, [](const BundleObservation& seen) { return seen.camera > 3; });
  const std::vector<double> sigmas = CenterSigmas({camera}, problem);
  EXPECT_LT(sigmas[1], 0.1);
  EXPECT_TRUE(std::isnan(sigmas[5])) << "it sees nothing";
}

TEST(BundleAdjustment, NothingToAdjustIsNotUsable) {
  BundleProblem empty;
  EXPECT_FALSE(AdjustBundle(test::SceneCamera(), empty).usable);
}

TEST(Residuals, DerivativesAgreeWithDifferences) {
  const CameraModel fisheye{640, 480, 300, 302, 322, 241, Distortion::kFisheye, {0.02, -0.004, 0.001, 0, 0}};
  for (const CameraModel& camera : {test::SceneCamera(), CameraModel::Pinhole(640, 480, 500), fisheye})
    for (const unsigned seed : {1u, 2u, 3u}) {
      Draw draw(seed);
      const Rigid3 pose = test::RandomPose(draw, 0.5, 0.5);
      Eigen::Vector3d point = pose.Inverse() * Eigen::Vector3d(draw.Uniform(-1, 1), draw.Uniform(-1, 1), 4);
      const ReprojectionCost cost(camera, {300, 200}, 0.7);
      PoseBlock block = ToBlock(pose);
      const double* parameters[] = {block.data(), point.data()};
      Eigen::Vector2d residual;
      Eigen::Matrix<double, 2, 7, Eigen::RowMajor> by_pose;
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
      double* jacobians[] = {by_pose.data(), by_point.data()};
      ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));

      const PoseManifold manifold;
      const auto residual_at = [&](const Eigen::Matrix<double, 6, 1>& delta, const Eigen::Vector3d& shift) {
        PoseBlock moved;
        manifold.Plus(block.data(), delta.data(), moved.data());
        const Eigen::Vector3d moved_point = point + shift;
        const double* at[] = {moved.data(), moved_point.data()};
        Eigen::Vector2d value;
        cost.Evaluate(at, value.data(), nullptr);
        return value;
      };
      constexpr double kStep = 1e-6;
      for (int k = 0; k < 6; ++k) {
        Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
        delta(k) = kStep;
        const Eigen::Vector2d numeric =
            (residual_at(delta, Eigen::Vector3d::Zero()) - residual_at(-delta, Eigen::Vector3d::Zero())) /
            (2 * kStep);
        EXPECT_LT((numeric - by_pose.col(k)).norm(), 1e-4 * (1 + numeric.norm())) << "pose " << k;
      }
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d shift = kStep * Eigen::Vector3d::Unit(k);
        const Eigen::Matrix<double, 6, 1> still = Eigen::Matrix<double, 6, 1>::Zero();
        const Eigen::Vector2d numeric =
            (residual_at(still, shift) - residual_at(still, -shift)) / (2 * kStep);
        EXPECT_LT((numeric - by_point.col(k)).norm(), 1e-4 * (1 + numeric.norm())) << "point " << k;
      }
    }
}

TEST(BundleAdjustment, FreeIntrinsicsFindTheLens) {
  const CameraModel camera = test::SceneCamera();
  for (const unsigned seed : {1u, 2u, 3u}) {
    Scene scene = MakeScene(0.2, 0, seed, camera);
    scene.disturbed.fixed = {true, false, false, false, false, false};
    CameraModel wrong = camera;
    wrong.fx *= 1.05;
    wrong.fy *= 1.05;
    wrong.coefficients[0] = 0;
    std::vector<CameraModel> lenses{wrong};
    BundleOptions options{.robust_iterations = 60, .iterations = 40, .function_tolerance = 1e-9};
    options.free = {.focal = true, .k1 = true};
    const BundleSummary summary = AdjustBundle(lenses, scene.disturbed, options);
    ASSERT_TRUE(summary.usable);
    EXPECT_NEAR(lenses[0].fx, camera.fx, 0.01 * camera.fx) << "seed " << seed;
    EXPECT_NEAR(lenses[0].coefficients[0], camera.coefficients[0], 0.02) << "seed " << seed;
    EXPECT_NEAR(lenses[0].fx / lenses[0].fy, camera.fx / camera.fy, 1e-9);
    EXPECT_EQ(lenses[0].cx, camera.cx);
    EXPECT_EQ(lenses[0].coefficients[1], camera.coefficients[1]);
  }
}

// The views of one half have another lens: each is found from its own views.
TEST(BundleAdjustment, LensesAreFoundSeparately) {
  const CameraModel camera = test::SceneCamera();
  Scene scene = MakeScene(0.2, 0, 4, camera);
  std::vector<CameraModel> lenses{camera, camera};
  lenses[1].fx *= 1.03;
  lenses[1].fy *= 1.03;
  scene.disturbed.lens = {0, 0, 0, 1, 1, 1};
  BundleOptions options{.robust_iterations = 60, .iterations = 40, .function_tolerance = 1e-9};
  options.free = {.focal = true};
  ASSERT_TRUE(AdjustBundle(lenses, scene.disturbed, options).usable);
  for (const CameraModel& lens : lenses) EXPECT_NEAR(lens.fx, camera.fx, 0.01 * camera.fx);
  EXPECT_NE(lenses[0].fx, lenses[1].fx);
}

TEST(BundleAdjustment, ProgressCountsAndAStopIsObeyed) {
  const CameraModel camera = test::SceneCamera();
  Scene scene = MakeScene(0.5, 0.05, 5, camera);
  std::atomic<bool> stop = false;
  BundleOptions options;
  int last = 0;
  options.progress = [&](int count) {
    EXPECT_EQ(count, last + 1);
    last = count;
    stop = count == 3;
  };
  options.stop = &stop;
  EXPECT_TRUE(AdjustBundle(camera, scene.disturbed, options).usable);
  EXPECT_EQ(last, 3);
}

// Where a loop has just been closed everything is off by pixels: what is cut short must not take that for
// wrong observations.
TEST(BundleAdjustment, InterruptedRunDoubtsNothing) {
  const CameraModel camera = test::SceneCamera();
  Scene scene = MakeScene(0.5, 0.05, 5, camera);
  const std::atomic<bool> stop = true;
  BundleOptions options;
  options.stop = &stop;
  const BundleSummary summary = AdjustBundle(camera, scene.disturbed, options);
  EXPECT_EQ(summary.outliers, 0);
  for (const BundleObservation& seen : scene.disturbed.observations) EXPECT_FALSE(seen.outlier);
}

TEST(Residuals, IntrinsicDerivativesAgreeNumerically) {
  const CameraModel fisheye{640, 480, 300, 302, 322, 241, Distortion::kFisheye, {0.02, -0.004, 0.001, 0, 0}};
  const FreeIntrinsics all{.focal = true, .principal_point = true, .k1 = true, .k2 = true};
  for (const CameraModel& camera : {test::SceneCamera(), fisheye}) {
    Draw draw(7);
    const PoseBlock pose = ToBlock(test::RandomPose(draw, 0.5, 0.5));
    const Eigen::Vector3d point =
        FromBlock(pose.data()).Inverse() * Eigen::Vector3d(draw.Uniform(-1, 1), draw.Uniform(-1, 1), 4);
    const IntrinsicsReprojectionCost cost(camera, {300, 200}, 0.7);
    const IntrinsicsBlock block = ToBlock(camera);
    const double* parameters[] = {pose.data(), point.data(), block.data()};
    Eigen::Vector2d residual;
    Eigen::Matrix<double, 2, 9, Eigen::RowMajor> by_lens;
    double* jacobians[] = {nullptr, nullptr, by_lens.data()};
    ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));
    const IntrinsicsManifold manifold(camera, all);
    ASSERT_EQ(manifold.TangentSize(), 5);
    Eigen::Matrix<double, 9, 5, Eigen::RowMajor> directions;
    manifold.PlusJacobian(block.data(), directions.data());
    for (int k = 0; k < 5; ++k) {
      constexpr double kStep = 1e-6;
      const auto residual_at = [&](double step) {
        const Eigen::Matrix<double, 5, 1> delta = Eigen::Matrix<double, 5, 1>::Unit(k) * step;
        IntrinsicsBlock moved;
        manifold.Plus(block.data(), delta.data(), moved.data());
        const double* at[] = {pose.data(), point.data(), moved.data()};
        Eigen::Vector2d value;
        cost.Evaluate(at, value.data(), nullptr);
        return value;
      };
      const Eigen::Vector2d numeric = (residual_at(kStep) - residual_at(-kStep)) / (2 * kStep);
      EXPECT_LT((numeric - by_lens * directions.col(k)).norm(), 1e-4 * (1 + numeric.norm())) << k;
    }
  }
}

}  // namespace
}  // namespace ulf::bundle_adjustment_test
