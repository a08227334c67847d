// Tests: tracking/refine/refine_rows, tracking/refine/refine_input.
#include "tracking/refine/refine_rows.h"

#include <gtest/gtest.h>

#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/tracking/refine/refine_views.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tracking/refine/refine_input.h"

namespace ulf::test::refine_rows_test {
namespace {

constexpr double kReadout_s = 0.02;

// Points that a hand's rolling shutter sees while it moves differently at every view. The views' poses are
// the pictures'.
struct RollingScene {
  RefineInput input;
  RefineScene scene;
  std::vector<Rigid3> middle_rows, pictures;
};

std::optional<Eigen::Vector2d> SeenWhileMoving(const CameraModel& camera, const Rigid3& pose,
                                               const Twist& twist, const Eigen::Vector3d& point) {
  std::optional<Eigen::Vector2d> img = camera.ImgFromCam(pose * point);
  for (int i = 0; i < 5 && img; ++i)
    img = camera.ImgFromCam(PointAfter(twist, pose * point, RowTime(kReadout_s, img->y(), camera.height)));
  return img;
}

RollingScene MakeRollingScene(unsigned seed, double recorded_share) {
  RollingScene made;
  Draw draw(seed);
  const CameraModel camera = SceneCamera();
  made.input.lenses = made.scene.lenses = {camera};
  made.input.readout_s = kReadout_s;
  std::vector<Twist> twists;
  for (int v = 0; v < 12; ++v) {
    const Eigen::Vector3d center(0.12 * (v % 4) - 0.2, 0.12 * (v / 4) - 0.1, draw.Uniform(-0.05, 0.05));
    made.middle_rows.push_back(LookAt(center, {0, 0, 2.5}, -Eigen::Vector3d::UnitY()));
    Twist& twist = twists.emplace_back();
    twist << 0.5 * draw.Direction(), 0.4 * draw.Direction();
    Twist off;
    for (int k = 0; k < 6; ++k) off(k) = draw.Normal(0.03);
    made.input.views.push_back({"", 0, {}, 0, twist + off});
    if (draw.Uniform(0, 1) >= recorded_share) made.input.views.back().twist.reset();
    made.scene.views.emplace_back();
  }
  std::vector<std::vector<PointObservation>> seen(made.middle_rows.size());
  for (int p = 0; p < 300; ++p) {
    SceneTrack track;
    track.position = {draw.Uniform(-1.2, 1.2), draw.Uniform(-0.9, 0.9), draw.Uniform(2, 3.5)};
    for (int v = 0; v < static_cast<int>(made.middle_rows.size()); ++v) {
      const std::size_t at = static_cast<std::size_t>(v);
      auto img = SeenWhileMoving(camera, made.middle_rows[at], twists[at], track.position);
      if (!img || !camera.Contains(*img)) continue;
      seen[at].push_back({track.position, *img, 1});
      track.observations.push_back({v, -1, *img + Eigen::Vector2d(draw.Normal(0.2), draw.Normal(0.2)), 0.5});
    }
    if (track.observations.size() > 3) made.scene.tracks.push_back(std::move(track));
  }
  for (std::size_t v = 0; v < seen.size(); ++v) {
    made.pictures.push_back(RefinePose(camera, seen[v], made.middle_rows[v],
                                       {.huber_sigmas = 1e3, .gate_sigmas = 1e3, .rounds = 1})
                                ->cam_from_world);
    made.scene.views[v].cam_from_world = made.scene.views[v].start = made.input.views[v].cam_from_world =
        made.pictures[v];
  }
  return made;
}

double Error(const std::vector<Rigid3>& truth, const RefineScene& scene, bool middle_rows) {
  return ErrorsOf(truth,
                  [&](std::size_t v) {
                    const RefineView& view = scene.views[v];
                    return middle_rows ? *view.middle_row_from_picture * view.cam_from_world
                                       : view.cam_from_world;
                  })
      .center;
}

TEST(RefineRows, RowsThatAreKnownGiveBetterPoses) {
  for (const double recorded_share : {1.0, 0.5})
    for (const unsigned seed : {1u, 2u}) {
      RollingScene known = MakeRollingScene(seed, recorded_share);
      RefineScene plain = known.scene;
      const BundleOptions options{
          .robust_iterations = 12, .iterations = 12, .cauchy_scales = 2, .gate_scales = 4};
      ASSERT_TRUE(AdjustRows(known.input, options, known.scene).usable);
      BundleProblem problem = ToBundle(plain);
      ASSERT_TRUE(AdjustBundle(plain.lenses[0], problem, options).usable);
      FromBundle(problem, 3, plain);
      const double with = Error(known.pictures, known.scene, false),
                   without = Error(known.pictures, plain, false);
      EXPECT_LT(with, 0.5 * without) << recorded_share << ", seed " << seed;
      EXPECT_LT(Error(known.middle_rows, known.scene, true), 0.003) << recorded_share << ", seed " << seed;
    }
}

TEST(RefineRows, ALightFieldTellsReadoutAndVelocities) {
  LightField light_field;
  light_field.views.resize(2);
  light_field.views[1].twist = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  EXPECT_EQ(RefineInputOf(light_field).readout_s, 0);
  light_field.readout = ShutterReadout{-0.03, {}};
  const RefineInput input = RefineInputOf(light_field);
  EXPECT_EQ(input.readout_s, -0.03);
  EXPECT_FALSE(input.views[0].twist);
  EXPECT_EQ((*input.views[1].twist)(3), 0.4);
}

}  // namespace
}  // namespace ulf::test::refine_rows_test
