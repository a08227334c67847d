// Tests: render/proxy/proxy, render/proxy/points_proxy, render/proxy/depth_raster, render/proxy/shadow_map,
// render/proxy/visible_points.
#include "render/proxy/proxy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/base/error.h"
#include "render/fields/field_options.h"
#include "render/fields/lumigraph_field.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/depth_raster.h"
#include "render/proxy/points_proxy.h"
#include "render/proxy/proxy_choice.h"
#include "render/proxy/visible_points.h"
#include "render/quality/quality.h"
#include "render/renderer/renderer.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::proxy_test {
namespace {

using Eigen::Vector3d;

const CameraModel kCamera = CameraModel::Pinhole(160, 120, 200);

Rigid3 At(const Vector3d& center) { return LookAt(center, Vector3d(0.02, -0.01, 0), Vector3d::UnitY()); }

test::SceneSpec SquareSpec(double half_angle = 0.6) {
  return {.viewpoints = test::CapViewpoints(50, half_angle, 2.0, 0.03),
          .width = 320,
          .height = 240,
          .focal_px = 260,
          .with_square = true};
}

std::shared_ptr<const Proxy> SquareProxy(const RenderScene& scene) {
  return std::make_shared<MeshProxy>(scene.subject, test::PlaneAndSquare());
}

double Psnr(const Rendering& picture, const cv::Mat& truth) {
  return CompareImages(Srgb8FromLinear(picture.linear), truth, cv::Mat(truth.size(), CV_8U, 255)).psnr_db;
}

// Of the pixels, how many are deep by more than 3 % of the truth.
double WrongShare(const cv::Mat& depth, const Rigid3& pose) {
  cv::Mat truth = DrawInverseDepth(*test::PlaneAndSquare(), kCamera, pose), error;
  cv::multiply(depth, truth, error);
  error = cv::abs(error - 1);
  return static_cast<double>(cv::countNonZero(error > 0.03)) / static_cast<double>(depth.total());
}

TEST(DepthRaster, IsTheDepthOfThePlaneOfEachTriangle) {
  for (const Vector3d& center : {Vector3d(0.3, -0.2, 2.5), Vector3d(1.5, 0.2, 1.0), Vector3d(0, 0, 0.6)}) {
    const Rigid3 pose = At(center);
    const Rigid3 world_from_cam = pose.Inverse();
    const cv::Mat inverse = DrawInverseDepth(*test::PlaneAndSquare(), kCamera, pose);
    for (int y = 0; y < kCamera.height; y += 7)
      for (int x = 0; x < kCamera.width; x += 7) {
        const Vector3d ray((x + 0.5 - kCamera.cx) / kCamera.fx, (y + 0.5 - kCamera.cy) / kCamera.fy, 1);
        const Vector3d along = world_from_cam.rotation * ray;
        double truth = -center.z() / along.z();
        const double to_square = (test::kSquareZ - center.z()) / along.z();
        if ((center + to_square * along).head<2>().cwiseAbs().maxCoeff() <= test::kSquareHalf)
          truth = to_square;
        EXPECT_NEAR(inverse.at<float>(y, x) * truth, 1, 1e-4) << x << " " << y;
      }
  }
}

TEST(DepthRaster, CutsWhatReachesBehindTheCamera) {
  // A floor that runs from before the camera to behind it.
  TriangleMesh floor;
  floor.vertices = {{-50, 1, -50}, {50, 1, -50}, {0, 1, 80}};
  floor.triangles = {{0, 1, 2}};
  const cv::Mat inverse = DrawInverseDepth(floor, kCamera, Rigid3{});
  EXPECT_EQ(inverse.at<float>(10, 80), 0);                    // above the horizon
  EXPECT_NEAR(inverse.at<float>(119, 80), 59.5 / 200, 1e-4);  // y = 1 on the floor
  TriangleMesh behind = floor;
  for (auto& vertex : behind.vertices) vertex.z() -= 200;
  EXPECT_EQ(cv::countNonZero(DrawInverseDepth(behind, kCamera, Rigid3{})), 0);
}

TEST(FillHoles, TakesWhatIsAroundAndLeavesTheRest) {
  cv::Mat depth(37, 53, CV_32F);
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x)
      depth.at<float>(y, x) = 0.5f + 0.004f * static_cast<float>(x) + 0.002f * static_cast<float>(y);
  const cv::Mat slanted = depth.clone();
  FillHoles(depth);
  EXPECT_EQ(cv::norm(depth, slanted, cv::NORM_INF), 0);
  depth(cv::Rect(20, 10, 9, 14)).setTo(0);
  depth.at<float>(36, 52) = 0;
  FillHoles(depth);
  cv::Mat off = cv::abs(depth - slanted);
  EXPECT_LT(cv::norm(off, cv::NORM_INF), 0.02);  // its slope across the hole is 0.04
  off(cv::Rect(20, 10, 9, 14)).setTo(0);
  off.at<float>(36, 52) = 0;
  EXPECT_EQ(cv::countNonZero(off), 0);
}

TEST(FillHoles, OnePixelFillsAllAndNoneFillsNothing) {
  cv::Mat depth = cv::Mat::zeros(30, 41, CV_32F);
  FillHoles(depth);
  EXPECT_EQ(cv::countNonZero(depth), 0);
  depth.at<float>(3, 40) = 0.25f;
  FillHoles(depth);
  EXPECT_EQ(cv::countNonZero(depth != 0.25f), 0);
}

// A wall behind the subject with a hole in it: the photographs show it whole.
TEST(MeshProxy, AHoleIsAsDeepAsWhatIsAroundIt) {
  const auto scene = test::MakeScene(SquareSpec());
  auto pierced = std::make_shared<TriangleMesh>();
  const float z = -1.5f, half = 4, hole = 0.25f;  // the subject's plane lies at 0
  for (const auto& [x0, x1, y0, y1] : {std::array{-half, -hole, -half, half},
                                       {hole, half, -half, half},
                                       {-hole, hole, -half, -hole},
                                       {-hole, hole, hole, half}}) {
    const auto first = static_cast<std::uint32_t>(pierced->vertices.size());
    for (const auto& [x, y] : {std::pair{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}})
      pierced->vertices.emplace_back(x, y, z);
    pierced->triangles.push_back({first, first + 1, first + 2});
    pierced->triangles.push_back({first, first + 2, first + 3});
  }
  const auto proxy = std::make_shared<MeshProxy>(scene->subject, pierced);
  const Rigid3 pose = LookAt({0.1, 0, 2}, {0, 0, 0}, Vector3d::UnitY());
  cv::Mat drawn = DrawInverseDepth(*pierced, kCamera, pose);
  const cv::Mat holes = drawn == 0;
  ASSERT_GT(cv::countNonZero(holes), 300);
  ASSERT_LT(cv::countNonZero(holes), 3000);
  for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
    const auto renderer = MakeRenderer(scene, {.renderer = kind, .depth = true});
    renderer->SetProxy(proxy);
    const cv::Mat depth = renderer->Render(kCamera, pose).depth;
    double least = 0, most = 0;
    cv::minMaxLoc(depth, &least, &most, nullptr, nullptr, holes);
    EXPECT_GT(least, 3.3) << renderer->Name();  // the wall is 3.5 away, the plane 2
    EXPECT_LT(most, 3.7) << renderer->Name();
  }
}

TEST(MeshProxy, WithTheTrueSurfaceThePictureIsTrue) {
  const auto scene = test::MakeScene(SquareSpec());
  std::vector<std::pair<Rigid3, cv::Mat>> truths;
  for (const Vector3d& center : {Vector3d(-0.4, 0.45, 1.3), Vector3d(0.5, -0.3, 1.5)})
    truths.emplace_back(At(center), test::PhotographOfPlane(kCamera, At(center), true));
  for (const auto& [kind, field] : {std::pair{RendererKind::kGl, FieldKind::kLinear},
                                    {RendererKind::kGl, FieldKind::kSubdivision},
                                    {RendererKind::kGl, FieldKind::kLumigraph},
                                    {RendererKind::kGl, FieldKind::kNearest},
                                    {RendererKind::kReference, FieldKind::kSubdivision}}) {
    const auto renderer = MakeRenderer(scene, {.field = {.kind = field}, .renderer = kind});
    for (const auto& [pose, truth] : truths) {
      const double plane = Psnr(renderer->Render(kCamera, pose), truth);
      renderer->SetProxy(SquareProxy(*scene));
      const Rendering picture = renderer->Render(kCamera, pose);
      const std::string name = renderer->Name() + ", " + FieldName(field);
      EXPECT_GT(Psnr(picture, truth), plane + 4) << name;
      EXPECT_GT(Psnr(picture, truth), 29) << name;
      EXPECT_LT(picture.filled_px, 200) << name;
      renderer->SetProxy(scene->proxy);
      EXPECT_NEAR(Psnr(renderer->Render(kCamera, pose), truth), plane, 1e-6) << name;
    }
  }
}

TEST(MeshProxy, OpenGlEqualsTheReference) {
  const CameraModel camera = CameraModel::Pinhole(80, 60, 100);
  for (const Distortion distortion : {Distortion::kNone, Distortion::kFisheye}) {
    test::SceneSpec spec = SquareSpec();
    spec.distortion = distortion;
    spec.two_sizes = distortion == Distortion::kFisheye;
    const auto plain = test::MakeScene(spec);
    const auto scene = WithProxy(*plain, SquareProxy(*plain));
    const auto gl = MakeRenderer(scene, {.renderer = RendererKind::kGl});
    const auto reference = MakeRenderer(scene, {.renderer = RendererKind::kReference});
    for (const FieldKind field :
         {FieldKind::kLinear, FieldKind::kSubdivision, FieldKind::kLumigraphPerPixel, FieldKind::kNearest}) {
      gl->SetField({.kind = field});
      reference->SetField({.kind = field});
      for (const Vector3d& center : {Vector3d(0.1, -0.05, 1.0), Vector3d(2.2, 0.4, 1.2)}) {
        const Rigid3 pose = At(center);
        const Rendering fast = gl->Render(camera, pose), slow = reference->Render(camera, pose);
        // Edges of depth, and of sight, may fall to either side of a pixel's centre.
        cv::Mat difference;
        cv::absdiff(Srgb8FromLinear(fast.linear), Srgb8FromLinear(slow.linear), difference);
        cv::Mat channels[3], largest;
        cv::split(difference, channels);
        largest = cv::max(channels[0], cv::max(channels[1], channels[2]));
        EXPECT_GE(static_cast<double>(cv::countNonZero(largest <= 2)),
                  0.985 * static_cast<double>(largest.total()))
            << FieldName(field) << " " << center.transpose();
        EXPECT_NEAR(static_cast<double>(fast.filled_px - slow.filled_px), 0, 25) << FieldName(field);
      }
    }
  }
}

TEST(ShadowMap, IsTheShareThatTheOccluderLeaves) {
  const auto scene =
      test::MakeScene({.viewpoints = {{0, 0, 2}}, .width = 320, .height = 240, .focal_px = 260});
  const auto with = WithProxy(*scene, SquareProxy(*scene));
  const SceneView& view = with->views[0];
  ASSERT_TRUE(view.shadow_map);
  EXPECT_TRUE(view.ProjectVisible({0, 0, test::kSquareZ}));  // the square itself
  EXPECT_TRUE(view.ProjectVisible({0.13, -0.13, test::kSquareZ}));
  EXPECT_FALSE(view.ProjectVisible({0, 0, 0}));  // the plane behind it
  EXPECT_TRUE(view.Project({0, 0, 0}));
  EXPECT_TRUE(view.ProjectVisible({0.4, 0.3, 0}));  // beside it
  // Sight fades around the shadow's edge.
  const double edge = test::kSquareHalf * 2 / (2 - test::kSquareZ);
  const double texel = 2.0 * view.camera.width / view.camera.fx / kShadowMapPx;
  EXPECT_EQ(view.shadow_map->Get().Visibility(view.cam_from_world * Vector3d(edge + 2.6 * texel, 0, 0)), 1);
  const double fading =
      view.shadow_map->Get().Visibility(view.cam_from_world * Vector3d(edge + 1.25 * texel, 0, 0));
  EXPECT_GT(fading, 0);
  EXPECT_LT(fading, 1);
  EXPECT_EQ(view.shadow_map->Get().Visibility(view.cam_from_world * Vector3d(edge - 0.1 * texel, 0, 0)), 0);
  // A plane proxy hides nothing, whatever was hidden before.
  EXPECT_TRUE(WithProxy(*with, scene->proxy)->views[0].ProjectVisible({0, 0, 0}));
}

TEST(ShadowMap, ASlantedSurfaceDoesNotHideItself) {
  // Seen at 8 degrees.
  const auto scene =
      test::MakeScene({.viewpoints = {{1.98, 0, 0.28}}, .width = 320, .height = 240, .focal_px = 260});
  auto plane = std::make_shared<TriangleMesh>();
  plane->vertices = {{-100, -100, 0}, {100, -100, 0}, {0, 100, 0}};
  plane->triangles = {{0, 1, 2}};
  const auto with = WithProxy(*scene, std::make_shared<MeshProxy>(scene->subject, plane));
  for (double x = -0.6; x < 0.9; x += 0.0173)
    for (double y = -0.4; y < 0.4; y += 0.0191)
      EXPECT_EQ(
          with->views[0].shadow_map->Get().Visibility(with->views[0].cam_from_world * Vector3d(x, y, 0)), 1)
          << x << " " << y;
}

TEST(ShadowMap, ARoughSurfaceDoesNotHideItself) {
  // Low steps, as depth maps leave them, seen at 35 degrees.
  const auto scene =
      test::MakeScene({.viewpoints = {{1.64, 0, 1.15}}, .width = 320, .height = 240, .focal_px = 260});
  auto steps = std::make_shared<TriangleMesh>();
  constexpr float kStep = 0.05f, kHeight = 0.012f;
  for (int i = -60; i < 30; ++i) {
    const float z = i % 2 ? kHeight : 0, next = i % 2 ? 0 : kHeight;
    const auto first = static_cast<std::uint32_t>(steps->vertices.size());
    for (const float y : {-10.0f, 10.0f})
      for (const auto& [x, height] : {std::pair{kStep * i, z}, {kStep * (i + 1), z}, {kStep * (i + 1), next}})
        steps->vertices.push_back({x, y, height});
    for (const auto& [a, b] : {std::pair{0u, 1u}, {1u, 2u}}) {
      steps->triangles.push_back({first + a, first + b, first + a + 3});
      steps->triangles.push_back({first + b, first + b + 3, first + a + 3});
    }
  }
  const auto with = WithProxy(*scene, std::make_shared<MeshProxy>(scene->subject, steps));
  int hidden = 0, all = 0;
  for (int i = -20; i < 12; ++i)
    for (double y = -0.3; y < 0.3; y += 0.0191) {
      const Vector3d on_tread(kStep * (i + 0.5), y, i % 2 ? kHeight : 0);
      hidden += with->views[0].shadow_map->Get().Visibility(with->views[0].cam_from_world * on_tread) < 1;
      ++all;
    }
  EXPECT_LT(hidden, all / 10);
}

TEST(PlaneProxyTest, FacesTheCameraAtAShareOfTheDistance) {
  const Subject subject{{0.1, -0.2, 0}, 0.3};
  const Rigid3 pose = LookAt({0.5, 0, 2}, {0, 0, 0}, {0, 1, 0});
  const double distance = (pose * subject.center_in_world).norm();
  const auto near = ProxyFromName("plane:0.75", subject, {});
  EXPECT_EQ(near->Name(), "plane:0.75");
  EXPECT_NEAR(near->Background(pose).offset, 0.75 * distance, 1e-12);
  EXPECT_NE(near->Fingerprint(), PlaneProxy(subject).Fingerprint());
  EXPECT_EQ(ProxyFromName("plane:1", subject, {})->Name(), "plane");
  for (const char* bad :
       {"plane:0", "plane:-1", "plane:nan", "plane:1,2", "plane:0.5x", "plane:inf", "plane:fitted"})
    EXPECT_THROW(ProxyFromName(bad, subject, {}), Refusal) << bad;
}

TEST(PointsProxy, IsTheSurfaceThatThePointsAreOf) {
  const PointsProxy proxy({Vector3d::Zero(), 0.3}, test::PointsOfPlaneAndSquare(20000, 400));
  const PlaneProxy plane({Vector3d::Zero(), 0.3});
  for (const Vector3d& center : {Vector3d(-0.4, 0.45, 1.3), Vector3d(0.5, -0.3, 1.5), Vector3d(0, 0, 2.2)}) {
    const Rigid3 pose = At(center);
    // What is wrong is the width of a triangle round the square.
    EXPECT_LT(WrongShare(proxy.Depth(kCamera, pose), pose), 0.05) << center.transpose();
    EXPECT_GT(WrongShare(plane.Depth(kCamera, pose), pose), 0.05) << "the test shows nothing";
  }
}

TEST(PointsProxy, ExcludesHiddenPoints) {
  // Two squares, one twice as far away as the other and as large as it looks, both full of points.
  std::vector<Vector3d> in_cam;
  cv::RNG random(3);
  for (int i = 0; i < 1500; ++i) {
    const double x = random.uniform(-0.4, 0.4), y = random.uniform(-0.3, 0.3);
    in_cam.push_back(i % 2 == 0 ? Vector3d{x, y, 1} : Vector3d{2 * x, 2 * y, 2});
  }
  std::size_t near = 0, far = 0;
  for (const std::size_t i : VisiblePoints(in_cam, 0.8 * 0.6)) ++(i % 2 == 0 ? near : far);
  EXPECT_GT(near, 735u);
  EXPECT_LT(far, 75u);
}

TEST(PointsProxy, ASlantedSurfaceDoesNotHideItself) {
  std::vector<Vector3d> in_cam;
  cv::RNG random(4);
  for (int i = 0; i < 800; ++i) {
    const double x = random.uniform(-0.5, 0.5), y = random.uniform(-0.4, 0.4);
    in_cam.push_back(Vector3d{x, y, 1} * (1.5 / (1 - 1.2 * x)));  // a wall at fifty degrees
  }
  EXPECT_GT(VisiblePoints(in_cam, 0.8).size(), 760u);
}

TEST(PointsProxy, AWrongPointIsNotBelieved) {
  auto points = test::PointsOfPlaneAndSquare(3000, 0);
  points.push_back({{0.1, 0.05, 0.9}});
  const PointsProxy proxy({Vector3d::Zero(), 0.3}, points);
  const Rigid3 pose = At({0, 0, 2});
  const cv::Mat depth = proxy.Depth(kCamera, pose);
  for (int y = 0; y < kCamera.height; y += 3)
    for (int x = 0; x < kCamera.width; x += 3) EXPECT_GT(depth.at<float>(y, x), 1.8) << x << " " << y;
}

TEST(PointsProxy, WithoutPointsItIsThePlaneOrAnError) {
  const Subject subject{Vector3d::Zero(), 0.3};
  const PointsProxy proxy(subject, test::PointsOfPlaneAndSquare(500, 0));
  const Rigid3 away = LookAt({0, 0, 2}, {0, 0, 4}, Vector3d::UnitY());
  EXPECT_FALSE(proxy.Triangles(kCamera, away));
  EXPECT_TRUE(cv::checkRange(proxy.Depth(kCamera, away), true, nullptr, 1e-6));
  auto broken = test::PointsOfPlaneAndSquare(3, 0);
  broken.push_back({{std::nan(""), 0, 0}});
  EXPECT_THAT([&] { PointsProxy(subject, broken); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("3 tracked points")));
}

TEST(PointsProxy, OpenGlDrawsWhatTheReferenceDraws) {
  test::SceneSpec spec = SquareSpec();
  spec.viewpoints = test::CapViewpoints(25, 0.6, 2.0, 0.03);
  spec.width = 160, spec.height = 120, spec.focal_px = 130;
  const auto plain = test::MakeScene(spec);
  const auto scene = WithProxy(
      *plain, std::make_shared<PointsProxy>(plain->subject, test::PointsOfPlaneAndSquare(1500, 40)));
  const Rigid3 pose = At({0.1, -0.05, 1.2});
  const auto gl = MakeRenderer(scene, {.renderer = RendererKind::kGl});
  const auto reference = MakeRenderer(scene, {.renderer = RendererKind::kReference});
  const Rendering fast = gl->Render(kCamera, pose), slow = reference->Render(kCamera, pose);
  cv::Mat difference;
  cv::absdiff(Srgb8FromLinear(fast.linear), Srgb8FromLinear(slow.linear), difference);
  EXPECT_LT(static_cast<double>(cv::countNonZero(difference.reshape(1) > 2)),
            0.01 * static_cast<double>(difference.reshape(1).total()));
  const cv::Mat truth = test::PhotographOfPlane(kCamera, pose, true);
  EXPECT_GT(Psnr(fast, truth), Psnr(MakeRenderer(plain, {})->Render(kCamera, pose), truth) + 3);
}

TEST(Proxy, FingerprintsDifferWhereTheGeometryDoes) {
  const Subject subject{Vector3d::Zero(), 0.3};
  const auto mesh = std::make_shared<TriangleMesh>(*test::PlaneAndSquare());
  const std::uint64_t of_mesh = MeshProxy(subject, mesh).Fingerprint();
  EXPECT_EQ(MeshProxy(subject, test::PlaneAndSquare()).Fingerprint(), of_mesh);
  mesh->vertices[1].x() += 1e-3f;
  EXPECT_NE(MeshProxy(subject, mesh).Fingerprint(), of_mesh);
  EXPECT_EQ(PlaneProxy(subject).Fingerprint(), PlaneProxy({Vector3d::Ones(), 1}).Fingerprint());
  const PlaneProxy::InWorld low{Vector3d::UnitZ(), 0}, high{Vector3d::UnitZ(), 1};
  EXPECT_NE(PlaneProxy(subject, low).Fingerprint(), PlaneProxy(subject, high).Fingerprint());
  EXPECT_NE(PointsProxy(subject, test::PointsOfPlaneAndSquare(20, 5)).Fingerprint(),
            PointsProxy(subject, test::PointsOfPlaneAndSquare(20, 6)).Fingerprint());
}

TEST(PlaneProxy, InTheWorldStaysWhereItIs) {
  const PlaneProxy proxy({Vector3d::Zero(), 0.3}, PlaneProxy::InWorld{Vector3d::UnitZ(), 0.1});
  for (const Vector3d& center : {Vector3d(0.5, 0.2, 2), Vector3d(0.3, 0.1, -1.4)}) {
    const Rigid3 pose = At(center);
    const cv::Mat depth = proxy.Depth(kCamera, pose);
    for (const auto& [x, y] : {std::pair{10, 15}, {80, 60}, {150, 100}}) {
      const Vector3d ray((x + 0.5 - kCamera.cx) / kCamera.fx, (y + 0.5 - kCamera.cy) / kCamera.fy, 1);
      EXPECT_NEAR((pose.Inverse() * (ray * depth.at<float>(y, x))).z(), 0.1, 1e-5);
    }
  }
}

}  // namespace
}  // namespace ulf::proxy_test
