// Tests: acquisition/simulator/scene/hard_scenes, acquisition/simulator/scene/surface_light,
// acquisition/simulator/scene/scene_builder, acquisition/simulator/scene/built_scenes.
//
// Mirrors, glass, thin things, the bust and what sways, against the laws that they claim to follow.
#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "acquisition/simulator/scene/surface_light.h"
#include "acquisition/simulator/simulated_camera.h"
#include "core/base/error.h"
#include "tests/support/floors.h"

namespace ulf::hard_scenes_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// The part with this finish that is nearest to the size asked for.
int PartWith(const Scene& scene, Finish finish, Shape shape) {
  for (std::size_t i = 0; i < scene.primitives().size(); ++i)
    if (scene.primitives()[i].finish == finish && scene.primitives()[i].shape == shape)
      return static_cast<int>(i);
  ADD_FAILURE() << "the scene has no such part";
  return 0;
}

Vector3d CenterOf(const Scene& scene, int part) {
  return scene.primitives()[static_cast<std::size_t>(part)].local_from_world.Inverse().translation;
}

F4 LightFrom(const Scene& scene, const Vector3d& eye, const Vector3d& direction, float pixel_angle) {
  const Hit hit = scene.FirstHit(eye, direction);
  const Primitive& primitive = scene.primitives()[static_cast<std::size_t>(hit.part)];
  const Vector3d point = eye + hit.distance * direction;
  const Vector3f local = (primitive.local_from_world * point).cast<float>();
  const SurfacePoint at = SurfaceAt(primitive, {local.x(), local.y(), local.z()});
  const Vector3d normal =
      primitive.local_from_world.Inverse().rotation * Vector3d(at.normal.x, at.normal.y, at.normal.z);
  const F4 matte = scene.Chart(primitive.first_chart + at.chart).Sample(at.u, at.v, 1);
  return SurfaceLight(scene, hit.part, matte,
                      {point.cast<float>(), normal.cast<float>(), direction.cast<float>(),
                       static_cast<float>(hit.distance), pixel_angle, 0});
}

// A ray through the middle of a ball is not bent: behind the ball it meets what it would meet without it,
// weakened twice by the surface and once by the way through.
TEST(Glass, RayThroughTheMiddleGoesStraight) {
  const auto scene = Scene::Named("glass");
  const int ball = PartWith(*scene, Finish::kGlass, Shape::kSphere);
  const Vector3d center = CenterOf(*scene, ball);
  constexpr float kFine = 1e-6f;  // no blur
  int compared = 0;
  for (const double lift : {0.3, 0.5, 0.8})
    for (const double turn : {-0.5, 0.0, 0.4}) {
      const Vector3d from = Vector3d(std::sin(turn), -std::cos(turn), lift).normalized();
      const Vector3d eye = center + 0.5 * from, direction = -from;
      ASSERT_EQ(scene->FirstHit(eye, direction).part, ball);
      const Hit behind = scene->FirstHit(eye, direction, 0, true);
      const Primitive& seen = scene->primitives()[static_cast<std::size_t>(behind.part)];
      if (seen.finish != Finish::kMatte) continue;
      const Vector3f local = (seen.local_from_world * (eye + behind.distance * direction)).cast<float>();
      const SurfacePoint at = SurfaceAt(seen, {local.x(), local.y(), local.z()});
      const F4 bare = scene->Chart(seen.first_chart + at.chart).Sample(at.u, at.v, 0.01f);
      const F4 light = LightFrom(*scene, eye, direction, kFine);
      for (int c = 0; c < 3; ++c) {
        // The mirror image in the front surface adds up to 4 % of the room's light.
        EXPECT_GT(light[c], 0.72f * bare[c]) << "channel " << c;
        EXPECT_LT(light[c], 0.95f * bare[c] + 0.06f) << "channel " << c;
      }
      ++compared;
    }
  EXPECT_GE(compared, 6);
}

// Off the middle it is bent twice, by Snell's law: in the plane of ray and centre, a ball turns it by
// 2 (i - r) and it leaves at 2 r - i from the straight way through the middle.
TEST(Glass, RayOffTheMiddleIsBentBySnellsLaw) {
  const auto scene = Scene::Named("glass");
  const int ball = PartWith(*scene, Finish::kGlass, Shape::kSphere);
  const double radius = scene->primitives()[static_cast<std::size_t>(ball)].size[0];
  const Vector3d center = CenterOf(*scene, ball), eye = center + Vector3d(-0.05, -0.55, 0.35);
  int compared = 0, bent = 0;
  for (const double share : {0.3, 0.5, 0.7})
    for (int turn = 0; turn < 8; ++turn) {
      const Vector3d axis = (center - eye).normalized(), side = axis.unitOrthogonal();
      const Vector3d aside = Eigen::AngleAxisd(turn * M_PI / 4, axis) * side;
      const Vector3d d = (center + share * radius * aside - eye).normalized();
      ASSERT_EQ(scene->FirstHit(eye, d).part, ball);
      const Vector3d off = (eye - center) - (eye - center).dot(d) * d, e = off.normalized();
      const double i = std::asin(off.norm() / radius), r = std::asin(std::sin(i) / 1.5);
      const Vector3d leaves = center + radius * (std::cos(2 * r - i) * d + std::sin(2 * r - i) * e);
      const Vector3d towards = std::cos(2 * (i - r)) * d - std::sin(2 * (i - r)) * e;
      const auto bare = [&](const Vector3d& from, const Vector3d& direction) {
        const Hit hit = scene->FirstHit(from + 1e-6 * direction, direction, 0, true);
        const Primitive& seen = scene->primitives()[static_cast<std::size_t>(hit.part)];
        const Vector3f local = (seen.local_from_world * (from + hit.distance * direction)).cast<float>();
        const SurfacePoint at = SurfaceAt(seen, {local.x(), local.y(), local.z()});
        return scene->Chart(seen.first_chart + at.chart).Sample(at.u, at.v, 0.01f);
      };
      const F4 expected = bare(leaves, towards), straight = bare(eye, d);
      const F4 light = LightFrom(*scene, eye, d, 1e-6f);
      bool as_straight = true;
      for (int c = 0; c < 3; ++c) {
        EXPECT_GT(light[c], 0.7f * expected[c]) << share << " " << turn << " channel " << c;
        EXPECT_LT(light[c], 0.97f * expected[c] + 0.06f) << share << " " << turn << " channel " << c;
        as_straight = as_straight && light[c] > 0.7f * straight[c] && light[c] < 0.97f * straight[c] + 0.06f;
      }
      ++compared;
      bent += !as_straight;
    }
  EXPECT_EQ(compared, 24);
  EXPECT_GT(bent, 12) << "straight rays would not explain what is seen";
}

TEST(Mirror, OnlyAPolishedSurfaceFollowsTheEye) {
  const auto scene = Scene::Named("gloss");
  const int ball = PartWith(*scene, Finish::kPolished, Shape::kSphere);
  const Vector3d center = CenterOf(*scene, ball);
  const double radius = scene->primitives()[static_cast<std::size_t>(ball)].size[0];
  double most_polished = 0, most_matte = 0;
  for (int i = 0; i < 200; ++i) {
    const double turn = 0.01 * (i - 100);
    const Vector3d point = center + radius * Vector3d(std::sin(turn), -std::cos(turn), 0.3).normalized();
    const Vector3d eyes[2] = {center + Vector3d(-0.3, -0.9, 0.4), center + Vector3d(0.3, -0.9, 0.4)};
    F4 seen[2];
    bool both = true;
    for (int eye = 0; eye < 2; ++eye) {
      const Vector3d direction = (point - eyes[eye]).normalized();
      const Hit hit = scene->FirstHit(eyes[eye], direction);
      both = both && hit.part == ball && std::abs(hit.distance - (point - eyes[eye]).norm()) < 1e-4;
      if (both) seen[eye] = LightFrom(*scene, eyes[eye], direction, 0.0018f);
    }
    if (!both) continue;
    for (int c = 0; c < 3; ++c)
      most_polished = std::max(most_polished, std::abs(static_cast<double>(seen[0][c] - seen[1][c])));
  }
  EXPECT_GT(most_polished, 0.08) << "mirror images move over the vase";
  // The torus on it is matte: its light is the texture alone.
  for (std::size_t i = 0; i < scene->primitives().size(); ++i) {
    if (scene->primitives()[i].finish != Finish::kMatte) continue;
    const SurfaceView view{{}, {0, 0, 1}, {0, 0, -1}, 1, 0.001f, 0};
    const F4 matte{0.1f, 0.2f, 0.3f, 0};
    const F4 light = SurfaceLight(*scene, static_cast<int>(i), matte, view);
    for (int c = 0; c < 3; ++c)
      most_matte = std::max(most_matte, std::abs(static_cast<double>(light[c] - matte[c])));
  }
  EXPECT_EQ(most_matte, 0);
}

// From its origin all of the bust's surface can be seen, or its charts would not cover it.
TEST(Bust, SurfaceIsSeenFromItsOrigin) {
  const auto scene = Scene::Named("bust");
  const auto bust = std::find_if(scene->primitives().begin(), scene->primitives().end(),
                                 [](const Primitive& part) { return part.shape == Shape::kBust; });
  ASSERT_NE(bust, scene->primitives().end());
  int compared = 0;
  for (int chart = 0; chart < 6; ++chart)
    for (float u = 0.05f; u < 1; u += 0.1f)
      for (float v = 0.05f; v < 1; v += 0.1f) {
        const ChartPoint at = PointOnChart(*bust, chart, u, v);
        const Vector3d direction = at.local.cast<double>().normalized();
        const Vector3d from = direction;  // a metre away
        const double distance = Intersect<double>(*bust, {from.x(), from.y(), from.z()},
                                                  {-direction.x(), -direction.y(), -direction.z()});
        EXPECT_NEAR(1 - distance, at.local.norm(), 2e-4) << chart << " " << u << " " << v;
        EXPECT_GT(at.normal.cast<double>().dot(direction), 0.02) << chart << " " << u << " " << v;
        const SurfacePoint back = SurfaceAt(*bust, {at.local.x(), at.local.y(), at.local.z()});
        EXPECT_EQ(back.chart, chart);
        EXPECT_NEAR(back.u, u, 1e-4);
        EXPECT_NEAR(back.v, v, 1e-4);
        ++compared;
      }
  EXPECT_EQ(compared, 600);
}

// Of the subject's pixels, those in which grey changes by less than this from one to the next, of 255.
constexpr float kGentle = 8;
double ShareOfSmoothPixels(const std::string& name) {
  SimulationOptions options;
  options.scene = name;
  options.noise = false;
  const SimulatedCamera camera(options);
  const Scene& scene = camera.scene();
  const Vector3d center = scene.subject().center_in_world;
  const Rigid3 pose =
      LookAt(center + scene.FirstDistance() * scene.FirstDirection(), center, Vector3d::UnitZ());
  cv::Mat gray, slope_x, slope_y, slope;
  cv::cvtColor(camera.CleanSrgb(pose), gray, cv::COLOR_BGR2GRAY);
  cv::Sobel(gray, slope_x, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(gray, slope_y, CV_32F, 0, 1, 3, 0.125);
  cv::magnitude(slope_x, slope_y, slope);
  int smooth = 0, of_subject = 0;
  for (int y = 0; y < gray.rows; y += 2)
    for (int x = 0; x < gray.cols; x += 2) {
      const Vector3d ray = pose.DirectionInSource(*camera.camera().RayFromImg({x + 0.5, y + 0.5}));
      const int part = scene.PartAlong(pose.OriginInSource(), ray);
      if (!scene.primitives()[static_cast<std::size_t>(part)].of_subject) continue;
      ++of_subject;
      smooth += slope.at<float>(y, x) < kGentle;
    }
  EXPECT_GT(of_subject, 800) << name;
  return static_cast<double>(smooth) / of_subject;
}

TEST(Bust, HasHardlyAnyTexture) {
  EXPECT_GT(ShareOfSmoothPixels("bust"), 0.75);
  EXPECT_LT(ShareOfSmoothPixels("studio"), 0.4);
}

TEST(Room, IsDeep) {
  const auto scene = Scene::Named("room");
  const CameraModel camera = SimulatedIntrinsics(320, 240);
  const RayCaster caster(scene, camera);
  const Vector3d center = scene->subject().center_in_world;
  const cv::Mat lengths = caster.RayLength(
      LookAt(center + scene->FirstDistance() * scene->FirstDirection(), center, Vector3d::UnitZ()));
  double nearest = 0, farthest = 0;
  cv::minMaxLoc(lengths, &nearest, &farthest);
  EXPECT_LT(nearest, 1.6);
  EXPECT_GT(farthest, 6.5);
}

TEST(Sway, BeginsAndEndsWhenAsked) {
  const auto scene = Scene::Named("branch");
  EXPECT_EQ(scene->SwayAngle(-0.1, 8), 0);
  EXPECT_EQ(scene->SwayAngle(0, 8), 0);
  EXPECT_EQ(scene->SwayAngle(8.01, 8), 0);
  double most = 0;
  for (double t = 0; t < 8; t += 0.01) most = std::max(most, std::abs(scene->SwayAngle(t, 8)));
  EXPECT_NEAR(most, scene->sway()->amplitude, 1e-3);
  EXPECT_EQ(Scene::Named("studio")->SwayAngle(1, 8), 0);

  SimulationOptions options = SimulationOptions::FromUri(
      DeviceUri::Parse("sim:branch?width=160&height=120&sways_from_s=2&sways_s=3"));
  const SimulatedCamera camera(options);
  EXPECT_EQ(camera.SwayAngle(1.9), 0);
  EXPECT_NE(camera.SwayAngle(3.3), 0);
  EXPECT_EQ(camera.SwayAngle(5.1), 0);
  EXPECT_THROW(SimulationOptions::FromUri(DeviceUri::Parse("sim:branch?sways_s=-1")), Refusal);
}

// What sways is somewhere else, the rest where it was; depth in eight lanes and in double precision agree.
TEST(Sway, MovesTheBranchAndNothingElse) {
  const auto scene = Scene::Named("branch");
  const CameraModel camera = SimulatedIntrinsics(320, 240);
  const RayCaster caster(scene, camera);
  const Vector3d center = scene->subject().center_in_world;
  const Rigid3 pose = LookAt(center + 0.5 * scene->FirstDirection(), center, Vector3d::UnitZ());
  const double angle = 0.8 * scene->sway()->amplitude;
  const cv::Mat rest = caster.RayLength(pose), moved = caster.RayLength(pose, angle);
  int changed = 0, changed_elsewhere = 0, wrong = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d ray = pose.DirectionInSource(*camera.RayFromImg({x + 0.5, y + 0.5}));
      const Hit before = scene->FirstHit(pose.OriginInSource(), ray);
      const Hit after = scene->FirstHit(pose.OriginInSource(), ray, angle);
      wrong += std::abs(after.distance - static_cast<double>(moved.at<float>(y, x))) > 2e-5;
      if (std::abs(rest.at<float>(y, x) - moved.at<float>(y, x)) < 1e-4f) continue;
      ++changed;
      const auto moves = [&](const Hit& hit) {
        return scene->primitives()[static_cast<std::size_t>(hit.part)].moves;
      };
      changed_elsewhere += !moves(before) && !moves(after);
    }
  EXPECT_GT(changed, 500);
  EXPECT_LT(changed_elsewhere, 8) << "rays along a silhouette";
  EXPECT_LT(wrong, 40) << "rays along a silhouette";
  // Pixels as well: a frame in the swing differs from one at rest, and one after it does not.
  SimulationOptions options;
  options.scene = "branch";
  options.width = 320;
  options.height = 240;
  options.noise = options.looks_away = false;
  options.sways_from_s = 1;
  options.sways_s = 3;
  const SimulatedCamera swaying(options);
  options.sways_s = 0;
  const SimulatedCamera still(options);
  const auto difference = [&](double open_s) {
    return cv::norm(swaying.Capture({.open_s = open_s}).image.pixels,
                    still.Capture({.open_s = open_s}).image.pixels, cv::NORM_INF);
  };
  EXPECT_EQ(difference(0.5), 0);
  EXPECT_GT(difference(2.2), 60);
  EXPECT_EQ(difference(4.5), 0);
}

}  // namespace
}  // namespace ulf::hard_scenes_test
